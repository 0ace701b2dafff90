#include "gelight/views/opencv.hpp"

#include <doctest/doctest.h>

#include "gelight/image/filter.hpp"

using gelight::Index;
using gelight::opencv_image;
using gelight::Rgb8;

TEST_CASE("a cv::Mat and a region of it are read and written in place") {
  cv::Mat_<float> whole(5, 7);
  for (int y = 0; y < 5; ++y) {
    for (int x = 0; x < 7; ++x) whole(y, x) = static_cast<float>(10 * y + x);
  }
  cv::Mat region = whole(cv::Rect(2, 1, 4, 3));
  const auto view = opencv_image<float>(region);
  REQUIRE(view.width() == 4);
  REQUIRE(view.height() == 3);
  CHECK(view(0, 0) == 12);
  CHECK(view(3, 2) == 35);
  view(1, 1) = -1;
  CHECK(whole(2, 3) == -1);
}

TEST_CASE("colours are pixels of three bytes, and an empty matrix is an empty image") {
  const cv::Mat colours(2, 3, CV_8UC3, cv::Scalar(1, 2, 3));
  CHECK(opencv_image<Rgb8>(colours)(2, 1) == Rgb8{1, 2, 3});
  const cv::Mat empty;
  CHECK(opencv_image<float>(empty).width() == 0);
}

TEST_CASE("a matrix of another type or more dimensions is refused") {
  cv::Mat bytes(2, 3, CV_8UC1);
  CHECK_THROWS_WITH_AS((void)opencv_image<float>(bytes), "the matrix is of OpenCV's type 0, not 5",
                       gelight::InvalidInput);
  const int sizes[] = {2, 3, 4};
  cv::Mat cube(3, sizes, CV_32FC1);
  CHECK_THROWS_WITH_AS((void)opencv_image<float>(cube), "the matrix has 3 dimensions, not 2",
                       gelight::InvalidInput);
}
