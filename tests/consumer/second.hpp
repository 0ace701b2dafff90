#pragma once

#include <gelight/gelight.hpp>

/// Distance from the first vertex to the last.
double by_fronts(const gelight::Mesh<double>& mesh);
