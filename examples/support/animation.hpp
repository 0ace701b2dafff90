#pragma once

#include <webp/encode.h>
#include <webp/mux.h>

#include <fstream>
#include <memory>
#include <stdexcept>
#include <string>

#include "gelight/core/types.hpp"
#include "gelight/views/image_view.hpp"

/// Images one after the other, for ever, as a WebP that browsers play.
class Animation {
 public:
  Animation(int width, int height, float quality = 80) : encoder_(nullptr, WebPAnimEncoderDelete) {
    WebPAnimEncoderOptions options;
    if (!WebPAnimEncoderOptionsInit(&options) || !WebPConfigInit(&config_)) fail("start");
    options.allow_mixed = 1;
    options.minimize_size = 1;
    config_.quality = quality;
    encoder_.reset(WebPAnimEncoderNew(width, height, &options));
    if (!encoder_) fail("start");
  }

  /// Shows an image for so long.
  void add(const gelight::Image<gelight::Rgb8>& image, int milliseconds) {
    WebPPicture picture;
    if (!WebPPictureInit(&picture)) fail("add to");
    picture.width = image.width();
    picture.height = image.height();
    picture.use_argb = 1;
    const bool is_added =
        WebPPictureImportRGB(&picture, image.pixels().data()->data(), 3 * image.width()) &&
        WebPAnimEncoderAdd(encoder_.get(), &picture, time_, &config_);
    WebPPictureFree(&picture);
    if (!is_added) fail("add to");
    time_ += milliseconds;
  }

  void save(const std::string& path) {
    WebPData data;
    WebPDataInit(&data);
    if (!WebPAnimEncoderAdd(encoder_.get(), nullptr, time_, nullptr) ||
        !WebPAnimEncoderAssemble(encoder_.get(), &data)) {
      fail("finish");
    }
    std::ofstream file(path, std::ios::binary);
    file.write(reinterpret_cast<const char*>(data.bytes), static_cast<std::streamsize>(data.size));
    WebPDataClear(&data);
    if (!file.flush()) throw std::runtime_error("cannot write " + path);
  }

 private:
  [[noreturn]] static void fail(const std::string& what) {
    throw std::runtime_error("libwebp could not " + what + " an animation");
  }

  WebPConfig config_;
  std::unique_ptr<WebPAnimEncoder, decltype(&WebPAnimEncoderDelete)> encoder_;
  int time_ = 0;  // of the next image, in milliseconds
};
