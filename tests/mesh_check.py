#!/usr/bin/env python3
"""Usage: tests/mesh_check.py MESH.ply [--closed]

Asks Open3D whether a mesh is a manifold that does not intersect itself. Exit code 0: it is; 1: it is
not; 77: Open3D is not there. Open3D compares all pairs of triangles: keep the mesh small.
"""

import sys

try:
    import open3d
except ImportError:
    print("Open3D for this Python is not installed (package python3-open3d)")
    sys.exit(77)

mesh = open3d.io.read_triangle_mesh(sys.argv[1])
answers = {
    "triangles": len(mesh.triangles) > 0,
    "edges of a manifold, apart from rims": mesh.is_edge_manifold(allow_boundary_edges=True),
    "vertices of a manifold": mesh.is_vertex_manifold(),
    "orientable": mesh.is_orientable(),
    "free of self-intersections": not mesh.is_self_intersecting(),
    "coloured": mesh.has_vertex_colors(),
}
if "--closed" in sys.argv[2:]:
    answers["closed"] = mesh.is_edge_manifold(allow_boundary_edges=False)
for what, holds in answers.items():
    print(f"{what}: {'yes' if holds else 'NO'}")
sys.exit(0 if all(answers.values()) else 1)
