#pragma once

// The one place with the version: CMake reads these three lines.
#define GELIGHT_VERSION_MAJOR 0
#define GELIGHT_VERSION_MINOR 1
#define GELIGHT_VERSION_PATCH 0
