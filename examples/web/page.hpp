#pragma once

#if defined(__EMSCRIPTEN__)
#define PAGE_EXPORT __attribute__((visibility("default"), used))
#else
#define PAGE_EXPORT
#endif

// The doors of page.cpp. Lengths are in metres, angles in radians, places in pixels of the image.

extern "C" {
PAGE_EXPORT const char* reason();          ///< why the last call failed
PAGE_EXPORT const float* answer();         ///< the numbers of the last call
PAGE_EXPORT const unsigned char* image();  ///< red, green, blue, 255 of each pixel

PAGE_EXPORT int set_sensor(int kind, int width, int height, float edge);  ///< fx fy cx cy
PAGE_EXPORT int set_object(int kind);
PAGE_EXPORT int set_renderer(int light, int smoothing, int solver);
PAGE_EXPORT int press(float u, float v, float depth, float turn);  ///< a pose, column by column
PAGE_EXPORT int lift();

PAGE_EXPORT int mesh_positions(int of_object);
PAGE_EXPORT int mesh_faces(int of_object);
PAGE_EXPORT int leds();  ///< place and colour of each

PAGE_EXPORT int set_solver(int solver);          ///< sets it up anew
PAGE_EXPORT int distances(int solver, int led);  ///< of each vertex
PAGE_EXPORT int isolines(float step);            ///< of the last distances, as pieces of two points
PAGE_EXPORT int path(int led, float u, float v);  ///< the shortest, as pieces
PAGE_EXPORT int fan(int led, int count);          ///< shortest paths all over, as pieces

PAGE_EXPORT int differences();  ///< threads.cpp, another program: of several threads from one
}
