#pragma once

// What solvers by heat share: a surface's factored systems, flows by them, and distances from
// those. It comes with the solvers, of which gelight.hpp has the doors.

#include "gelight/geodesic/heat/engine.hpp"
#include "gelight/geodesic/heat/flow.hpp"
#include "gelight/geodesic/heat/system.hpp"
