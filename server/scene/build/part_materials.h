// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <vector>

#include "geometry/mesh/mass_properties.h"
#include "geometry/triangle_mesh.h"
#include "livegs/v1/physics.pb.h"
#include "physics/elastic_body.h"
#include "physics/surface_friction.h"

namespace livegs {

// Effect of the parts of an object (PhysicalParameters::parts) on its body. The total mass stays; each part
// has its share of it, evenly within its place. Parts without material in their place leave their share to
// the others. The friction of a part is to that of the object as the two materials' frictions in the table;
// static objects, and elastic ones with the solver livegs-v1, have one friction. The functions do nothing if
// the object is not divided. Those with lines return one for display for each part whose boxes hold no
// material.

// Changes centre of mass and inertia of a rigid body, and sets density_kg_m3 of the parts. `shell`: the mass
// lies on the surface of the mesh.
std::vector<std::string> weigh_parts(const TriangleMesh& mesh, bool shell, v1::PhysicalParameters& parameters,
                                     MassProperties& properties);

// Empty if the friction is the same everywhere.
std::vector<FrictionBox> part_friction(const v1::PhysicalParameters& parameters);

// Adds the parts as material regions before those of the scene file, and sets their density_kg_m3. E* is s E
// of the part's material; that of the body where both are of one class. A part is at most ten times as stiff
// as the body. A stiffer part looks the same, and would reduce the stiffness of the others
// (lattice_resolution.h).
std::vector<std::string> add_part_regions(v1::PhysicalParameters& parameters, ElasticBodyDescription& body);

}  // namespace livegs
