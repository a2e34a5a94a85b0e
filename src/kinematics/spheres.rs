//! Where three spheres meet: a point from its distances to three others.
//!
//! With axes from the first centre, x towards the second and the third in the plane of x and y, the differences of the
//! spheres' equations are linear, one in x and one in x and y.

use crate::calls::{difference, dot, image, image_transposed, root, triad};
use crate::scalar::Real;
use crate::vector::sum;
use nalgebra::Vector3;

/// The point at these distances from the three centres, on one `side` of their plane: 1 where the centres are seen
/// numbered counterclockwise, -1 on the other. When the spheres do not meet, the point of the plane where their
/// differences agree. Not finite when the centres lie on one line.
#[inline(never)]
pub(super) fn spheres_meet<T: Real>([a, b, c]: [&Vector3<T>; 3], [ra, rb, rc]: &[T; 3], side: T) -> Vector3<T> {
    let (second, third) = (difference(b, a), difference(c, a));
    let axes = triad(&second, &third);
    let length = root(dot(&second, &second));
    let third = image_transposed(&axes, &third);
    // Differences of squares as products: single precision would lose the digits that matter.
    let x = ((*ra - *rb) * (*ra + *rb) + length * length) / (length + length);
    let y = ((*ra - *rc) * (*ra + *rc) + third.x * (third.x - x - x) + third.y * third.y) / (third.y + third.y);
    let height = root(((*ra - x) * (*ra + x) - y * y).max(T::zero())) * side;
    sum(a, &image(&axes, &Vector3::new(x, y, height)))
}
