//! Where three spheres meet: a point from its distances to three others.
//!
//! With the first centre as origin, x towards the second and the third in the plane of x and y, the differences of the
//! spheres' equations are linear, one in x and one in x and y.

use crate::calls::{difference, image, image_transposed, root, triad};
use crate::scalar::Real;
use nalgebra::Vector3;

/// The point at these distances from the three centres, seen from the first, on one `side` of their plane: 1 where they
/// are numbered counterclockwise, -1 on the other. When the spheres do not meet, the point of the plane where the
/// differences of their equations hold. Not finite when the centres lie on one line.
#[inline(never)]
pub(super) fn spheres_meet<T: Real>([a, b, c]: [&Vector3<T>; 3], [ra, rb, rc]: &[T; 3], side: T) -> Vector3<T> {
    let (second, third) = (difference(b, a), difference(c, a));
    let axes = triad(&second, &third);
    let (second, third) = (image_transposed(&axes, &second).x, image_transposed(&axes, &third));
    // Differences of squares as products: single precision would lose the digits that matter.
    let x = ((*ra - *rb) * (*ra + *rb) + second * second) / (second + second);
    let y = ((*ra - *rc) * (*ra + *rc) + third.x * (third.x - x - x) + third.y * third.y) / (third.y + third.y);
    let height = root(((*ra - x) * (*ra + x) - y * y).max(T::zero())) * side;
    image(&axes, &Vector3::new(x, y, height))
}
