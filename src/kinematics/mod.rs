//! Cable lengths, tetrahedra and the octahedron.
