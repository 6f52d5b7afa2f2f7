// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "geometry/mesh/mass_properties.h"
#include "geometry/triangle_mesh.h"
#include "livegs/v1/physics.pb.h"
#include "physics/elastic_body.h"

namespace livegs {

// Effect of the parts of an object (PhysicalParameters::parts) on its body. The total mass stays; each part
// has its share of it, evenly within its place. Parts without material in their place leave their share to
// the others. Both functions do nothing if the object is not divided, and set density_kg_m3 of the parts.

// Changes centre of mass and inertia of a rigid body. `shell`: the mass lies on the surface of the mesh.
void weigh_parts(const TriangleMesh& mesh, bool shell, v1::PhysicalParameters& parameters,
                 MassProperties& properties);

// Adds the parts as material regions before those of the scene file. E* is s E of the part's material; that
// of the body where both are of one class. A part is at most ten times as stiff as the body: what bends less
// is not visible, and it would take the stiffness from the others (lattice_resolution.h).
void add_part_regions(v1::PhysicalParameters& parameters, ElasticBodyDescription& body);

}  // namespace livegs
