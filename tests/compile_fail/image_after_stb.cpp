// expect: include no stb_image before it
// As stb_image.h does, which is not on the include path here.
#define STBI_INCLUDE_STB_IMAGE_H
#include "gelight/io/image.hpp"

int main() { (void)gelight::read_png("picture.png"); }
