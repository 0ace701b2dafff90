#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <random>
#include <span>
#include <utility>
#include <vector>

#include "gelight/image/normals.hpp"
#include "gelight/membrane/elastic.hpp"
#include "gelight/membrane/flat_gelsight.hpp"
#include "gelight/membrane/pyramid.hpp"
#include "gelight/membrane/shadowed.hpp"
#include "gelight/membrane/spring_membrane.hpp"
#include "gelight/sensor/tactile_renderer.hpp"

using namespace gelight;

namespace {

// As the concept's own page has it.
struct Rigid {
  struct Workspace {};
  Index reach() const { return 0; }
  Workspace make_workspace(Index, Index) const { return {}; }
  void press_into(ImageView<float> surface, const Press<float>& press, Workspace&) const {
    for (Index y = press.window.top; y < press.window.bottom; ++y) {
      for (Index x = press.window.left; x < press.window.right; ++x) {
        const float z = press.depth(x, y), rest = press.rest(x, y);
        surface(x, y) = z > 0 && z < rest ? z : rest;
      }
    }
  }
};

// The membrane of TactileRenderer, under another name: by the seam rather than by its own loops.
struct Plugged : GaussianMembrane<float> {
  using GaussianMembrane::GaussianMembrane;
};

// Depends on all pixels: the whole surface gives way by the deepest press.
struct Sinking {
  struct Workspace {};
  Index reach() const { return whole_image; }
  Workspace make_workspace(Index, Index) const { return {}; }
  void press_into(ImageView<float> surface, const Press<float>& press, Workspace&) const {
    float deepest = 0;
    for (Index y = 0; y < surface.height(); ++y) {
      for (Index x = 0; x < surface.width(); ++x) {
        const float z = press.depth(x, y), rest = press.rest(x, y);
        if (z > 0 && rest - z > deepest) deepest = rest - z;
      }
    }
    for (Index y = press.window.top; y < press.window.bottom; ++y) {
      for (Index x = press.window.left; x < press.window.right; ++x) {
        const float lean = 1 - static_cast<float>(x) / 400;
        surface(x, y) = press.rest(x, y) - deepest * lean;
      }
    }
  }
};

struct NormalMap {
  void shade_row(const ColourRow<float>& out, const SurfaceRow<float>& row) const {
    for (std::ptrdiff_t i = 0; i < row.count; ++i) {
      out.r[i] = (1 + row.nx[i]) / 2;
      out.g[i] = (1 + row.ny[i]) / 2;
      out.b[i] = (1 - row.nz[i]) / 2 * (row.kept != nullptr ? row.kept[i] : 1);
    }
  }
};

// White where an object touches, wherever it is asked.
struct TouchMap {
  static constexpr bool reads_touched = true;
  void shade_row(const ColourRow<float>& out, const SurfaceRow<float>& row) const {
    for (std::ptrdiff_t i = 0; i < row.count; ++i) {
      out.r[i] = out.g[i] = row.touched[i];
      out.b[i] = (1 - row.nz[i]) / 2;
    }
  }
};

// Break while told to: the membrane before a row is shown, the reflectance in the middle of them.
bool is_brittle = false;
struct Brittle : Rigid {
  void press_into(ImageView<float> surface, const Press<float>& press, Workspace& work) const {
    if (is_brittle) throw InvalidInput("the membrane breaks");
    Rigid::press_into(surface, press, work);
  }
};
struct BrittleMap : NormalMap {
  void shade_row(const ColourRow<float>& out, const SurfaceRow<float>& row) const {
    if (is_brittle && row.y > 60) throw InvalidInput("the reflectance breaks");
    NormalMap::shade_row(out, row);
  }
};

constexpr Index width = 150, height = 110;
const Camera<float> camera{130, 120, 74, 53, width, height};

Image<float> curved_rest() {
  Image<float> rest(width, height);
  for (Index y = 0; y < height; ++y) {
    for (Index x = 0; x < width; ++x) {
      rest(x, y) = 0.03f - 1e-7f * static_cast<float>((x - 70) * (x - 70) + (y - 50) * (y - 50));
    }
  }
  return rest;
}

// A ball somewhere on the membrane, with or without holes in what is known of it.
Image<float> pressed(std::mt19937& random, const Image<float>& rest, bool holes) {
  std::uniform_real_distribution<float> any(0, 1);
  const float cx = any(random) * width, cy = any(random) * height, radius = 3 + 15 * any(random);
  Image<float> depth(width, height, std::numeric_limits<float>::infinity());
  for (Index y = 0; y < height; ++y) {
    for (Index x = 0; x < width; ++x) {
      const float q = std::hypot(static_cast<float>(x) - cx, static_cast<float>(y) - cy) / radius;
      if (q < 1.3f) depth(x, y) = rest(x, y) - 0.0015f * (1 - q * q);
      if (holes && any(random) < 0.002f) depth(x, y) = any(random) < 0.5f ? 0 : std::nanf("");
    }
  }
  return depth;
}

std::vector<Light<float>> three_lights() {
  std::vector<Light<float>> lights;
  for (const float angle : {0.3f, 2.4f, 4.5f}) {
    const Vec3<float> along(std::cos(angle), std::sin(angle), 0.2f);
    lights.push_back(
        {Image<Vec3<float>>(width, height, along.normalized()), {angle / 5, 1 - angle / 5, 0.5f}});
  }
  return lights;
}

template <class Membrane, class Shine>
void check_frames(const Membrane& membrane, const Shine& shine, bool mask,
                  const Image<float>& whole_rest = curved_rest()) {
  Image<float> rest = whole_rest;
  if (mask) {
    for (Index y = 0; y < 30; ++y) std::fill_n(rest.row(y), 20, 0.f);
  }
  const TactileRenderer sparse(camera, rest, membrane, shine, {.darkening = 0.3});
  const TactileRenderer dense(camera, rest, membrane, shine,
                              {.darkening = 0.3, .skip_unchanged = false});
  CHECK(sparse.render(rest) == sparse.rest_image());
  CHECK(sparse.render(Image<float>(width, height, std::numeric_limits<float>::infinity())) ==
        sparse.rest_image());
  std::mt19937 random(7);
  auto frame = sparse.rest_frame();
  for (int i = 0; i < 24; ++i) {
    const Image<float> contact = pressed(random, whole_rest, i % 3 == 2);
    const auto image = sparse.render(contact);
    CHECK(image != sparse.rest_image());
    CHECK(image == dense.render(contact));
    sparse.render_next_into(frame, contact);
    CHECK(frame.image == image);
    Image<double> wide(width, height);
    std::copy(contact.pixels().begin(), contact.pixels().end(), wide.pixels().begin());
    CHECK(sparse.render(wide) == image);
  }
}

const std::array<double, 3> sigmas{4, 2, 0.7};

}  // namespace

TEST_CASE("frames of any membrane and reflectance: sparse, whole and in a sequence the same") {
  const PhongLights<float> phong{three_lights(), std::array{0.4f, 0.5f, 0.6f}};
  const SpringMembrane<float> springs(SpringBed<float>(camera, 0.03f), 0.5);
  for (const bool mask : {false, true}) {
    check_frames(Rigid{}, phong, mask);
    check_frames(Rigid{}, NormalMap{}, mask);
    check_frames(Sinking{}, phong, mask);
    check_frames(Plugged(3, 9), NormalMap{}, mask);
    check_frames(GaussianMembrane<float>(3, 9), TouchMap{}, mask);
    check_frames(PyramidMembrane<float>(sigmas), phong, mask);
    check_frames(GaussianMembrane<float>(3, 9), NormalMap{}, mask);
    check_frames(FlatGelSightMembrane<float>(), phong, mask);
    check_frames(ShadowedMembrane<float>(camera, GaussianMembrane<float>(3, 9)), phong, mask);
    check_frames(springs, NormalMap{}, mask, Image<float>(width, height, 0.03f));
  }
}

TEST_CASE("wherever a small contact lies, the image is that of the frame computed everywhere") {
  // A column and a row more than whole blocks, tiles and bands.
  constexpr Index wide = 145, high = 41;
  const Camera<float> eye{130, 120, 71, 19, wide, high};
  constexpr float inf = std::numeric_limits<float>::infinity();
  Image<float> flat(wide, high, 0.03f), slanted(wide, high), masked(wide, high);
  for (Index y = 0; y < high; ++y) {
    for (Index x = 0; x < wide; ++x) {
      slanted(x, y) = 0.03f + 2e-5f * static_cast<float>(x) - 1e-5f * static_cast<float>(y);
      masked(x, y) = x < 5 || (x > 100 && y < 9) ? 0 : slanted(x, y);
    }
  }
  const auto check = [&](const Image<float>& rest, const auto& membrane) {
    constexpr auto border = BorderNormals::extrapolated;
    const TactileRenderer sparse(eye, rest, membrane, NormalMap{}, {.border_normals = border});
    const TactileRenderer dense(eye, rest, membrane, NormalMap{},
                                {.border_normals = border, .skip_unchanged = false});
    // Around it the membrane, nothing, or a flat thing that lies still.
    Image<float> still = rest;
    for (Index y = 8; y < 33; ++y) {
      for (Index x = 30; x < 110; ++x) still(x, y) = rest(x, y) - 4e-4f;
    }
    auto frame = sparse.rest_frame();
    Image<Rgb8> out(wide, high);  // holds the last frame
    for (const auto& around : {rest, Image<float>(wide, high, inf), still}) {
      const auto at = [&](Index u, Index v) {
        // One pixel or a few, deep or hardly, and now and then one that is not known.
        const Index kind = (u + 3 * v) % 8, size = kind < 4 ? 1 : 3;
        Image<float> depth = around;
        for (Index y = v; y < std::min(high, v + size); ++y) {
          for (Index x = u; x < std::min(wide, u + size); ++x) {
            depth(x, y) = kind % 2 == 0 ? 0.02f : rest(x, y) - 8e-4f;
          }
        }
        if (kind == 5) depth(wide - 1 - u, high - 1 - v) = std::nanf("");
        CAPTURE(u);
        CAPTURE(v);
        const auto want = dense.render(depth);
        sparse.render_into(out, depth);
        CHECK(out == want);
        sparse.render_next_into(frame, depth);
        CHECK(frame.image == want);
      };
      for (Index u = 0; u < wide; ++u) at(u, 7 * u / 16 % high);
      for (Index v = 0; v < high; ++v) at(31 * (v / 4) % wide, v);
    }
  };
  // So wide that what is at the end of the reach shows.
  for (const auto& rest : {flat, slanted, masked}) check(rest, GaussianMembrane<float>(20, 5));
  for (const auto& rest : {flat, slanted, masked}) check(rest, Plugged(20, 5));
  check(slanted, GaussianMembrane<float>(20, 20));
  check(slanted, GaussianMembrane<float>(20, 5, false));
  check(slanted, GaussianMembrane<float>(0));
  check(slanted, Rigid{});
}

TEST_CASE("a sequence goes on after a frame in which the membrane or the reflectance threw") {
  const Image<float> rest = curved_rest();
  const Brittle membrane;
  const BrittleMap shine;
  const TactileRenderer whole(camera, rest, Rigid{}, NormalMap{});
  const TactileRenderer one(camera, rest, membrane, NormalMap{});
  const TactileRenderer other(camera, rest, Rigid{}, shine);
  std::mt19937 random(23);
  const auto check = [&](const auto& renderer) {
    auto frame = renderer.rest_frame();
    int thrown = 0;
    for (int i = 0; i < 30; ++i) {
      const Image<float> contact = pressed(random, rest, i % 3 == 2);
      const bool breaks = random() % 2 == 0;
      is_brittle = breaks;
      for (int again = 0; again < 2; ++again) {
        try {
          renderer.render_next_into(frame, contact);
          CHECK(frame.image == whole.render(contact));
        } catch (const InvalidInput&) {
          ++thrown;
          CHECK(breaks);
        }
        is_brittle = breaks && random() % 2 == 0;  // it may bear the same contact at the second try
      }
    }
    is_brittle = false;
    CHECK(thrown > 5);
  };
  check(one);
  check(other);
}

TEST_CASE("the seam itself changes nothing: the default membrane plugged in, and one of sigma 0") {
  const PhongLights<float> phong{three_lights(), std::array{0.4f, 0.5f, 0.6f}};
  const Image<float> rest = curved_rest();
  const TactileRenderer own(camera, rest, GaussianMembrane<float>(3, 9), phong);
  const TactileRenderer plugged(camera, rest, Plugged(3, 9), phong);
  const TactileRenderer follows(camera, rest, GaussianMembrane<float>(0), phong);
  const TactileRenderer rigid(camera, rest, Rigid{}, phong);
  const auto worst = [](const Image<Rgb8>& a, const Image<Rgb8>& b) {
    int most = 0;
    for (std::size_t i = 0; i < a.pixels().size(); ++i) {
      for (std::size_t c = 0; c < 3; ++c) {
        most = std::max(most, std::abs(a.pixels()[i][c] - b.pixels()[i][c]));
      }
    }
    return most;
  };
  CHECK(own.rest_image() == plugged.rest_image());
  std::mt19937 random(3);
  for (int i = 0; i < 12; ++i) {
    const auto contact = pressed(random, rest, i % 3 == 2);
    CHECK(worst(own.render(contact), plugged.render(contact)) <= 1);  // sums in another order
    CHECK(follows.render(contact) == rigid.render(contact));
  }
}

TEST_CASE("Phong alone needs no other words than a reflectance of one's own") {
  const auto lights = three_lights();
  const std::array colour{0.4f, 0.5f, 0.6f};
  const Image<float> rest = curved_rest();
  const TactileRenderer plain(camera, rest, lights, colour);
  const TactileRenderer plugged(camera, rest, GaussianMembrane<float>(),
                                PhongLights<float>{lights, colour});
  std::mt19937 random(5);
  for (int i = 0; i < 6; ++i) {
    const auto contact = pressed(random, rest, i == 5);
    CHECK(plain.render(contact) == plugged.render(contact));
  }
}

TEST_CASE("a reflectance sees the unit normals of the surface, in the camera's frame") {
  const Image<float> rest = curved_rest();
  const TactileRenderer renderer(camera, rest, Rigid{}, NormalMap{},
                                 {.border_normals = BorderNormals::extrapolated});
  std::mt19937 random(11);
  for (int i = 0; i < 6; ++i) {
    Image<float> contact = pressed(random, rest, false);
    for (std::size_t k = 0; k < contact.pixels().size(); ++k) {
      contact.pixels()[k] = std::min(contact.pixels()[k], rest.pixels()[k]);
    }
    const auto normals = sobel_normals(contact, camera, BorderNormals::extrapolated);
    const auto image = renderer.render(contact);
    for (Index y = 0; y < height; ++y) {
      for (Index x = 0; x < width; ++x) {
        const Vec3<float>& n = normals(x, y);
        const std::array share{(1 + n.x()) / 2, (1 + n.y()) / 2, (1 - n.z()) / 2};
        for (std::size_t c = 0; c < 3; ++c) {
          REQUIRE(std::abs(static_cast<float>(image(x, y)[c]) + 0.5f - 255 * share[c]) < 0.51f);
        }
      }
    }
  }
}

TEST_CASE("Taxim's membrane is the Gaussians of the protrusion, one after the other") {
  const Image<float> rest = curved_rest();
  const PyramidMembrane<float> membrane(sigmas);
  auto work = membrane.make_workspace(width, height);
  std::mt19937 random(13);
  for (int i = 0; i < 12; ++i) {
    const auto contact = pressed(random, rest, i % 2 == 1);
    // Without the seam: whole images.
    Image<float> protrusion(width, height), gel(width, height);
    for (std::size_t k = 0; k < gel.pixels().size(); ++k) {
      const float z = contact.pixels()[k];
      protrusion.pixels()[k] = z > 0 ? std::max(0.f, rest.pixels()[k] - z) : std::nanf("");
    }
    gel = protrusion;
    for (const double sigma : sigmas) {
      gel = gaussian_of_known(gel, sigma, static_cast<Index>(std::ceil(4 * sigma)));
      for (std::size_t k = 0; k < gel.pixels().size(); ++k) {
        if (protrusion.pixels()[k] > 0) gel.pixels()[k] = protrusion.pixels()[k];
      }
    }
    Image<float> surface(width, height, -1), part(width, height, -1);
    const Window whole{0, 0, width, height}, window{16, 9, 93, 71};
    membrane.press_into(surface, {contact, rest, whole}, work);
    membrane.press_into(part, {contact, rest, window}, work);
    for (Index y = 0; y < height; ++y) {
      for (Index x = 0; x < width; ++x) {
        const bool inside =
            x >= window.left && x < window.right && y >= window.top && y < window.bottom;
        REQUIRE(part(x, y) == (inside ? surface(x, y) : -1.f));
        if (!std::isnan(gel(x, y))) {
          REQUIRE(std::abs(surface(x, y) - (rest(x, y) - gel(x, y))) < 1e-8f);
        }
      }
    }
  }
}

TEST_CASE("membranes refuse what they cannot be") {
  const std::array bad{1.0, -1.0};
  CHECK_THROWS_AS(PyramidMembrane<float>{bad}, InvalidInput);
  const std::vector<double> many(600, 1e6);
  CHECK_THROWS_WITH_AS(PyramidMembrane<float>{many},
                       "600 sigmas reach 2400000000 pixels together, more than can be counted",
                       InvalidInput);
  CHECK_THROWS_AS(GaussianMembrane<float>(std::nan("")), InvalidInput);
  CHECK_THROWS_AS(GaussianMembrane<float>(1, -1), InvalidInput);
}

namespace {

// White where the renderer says that an object touches.
template <class T>
struct TouchedMap {
  static constexpr bool reads_touched = true;
  void shade_row(const ColourRow<T>& out, const SurfaceRow<T>& row) const {
    for (std::ptrdiff_t i = 0; i < row.count; ++i) {
      out.r[i] = out.g[i] = out.b[i] = row.touched[i];
    }
  }
};

}  // namespace

TEST_CASE_TEMPLATE("what lies flat on the gel touches it, however the mean over it is rounded", T,
                   float, double) {
  const Camera<T> eye{60, 60, T(23.5), T(23.5), 48, 48};
  const Image<T> rest(48, 48, T(0.03));
  int lost = 0, frames = 0;
  for (double sigma = 0.5; sigma < 5; sigma += 0.25) {
    const auto radius = static_cast<Index>(std::ceil(4 * sigma));
    const TactileRenderer sensor(eye, rest, GaussianMembrane<T>(sigma, radius), TouchedMap<T>{});
    for (double press = 1e-4; press < 3e-3; press *= 1.1) {
      const Image<T> depth(48, 48, static_cast<T>(0.03 - press));
      for (const Rgb8& pixel : sensor.render(depth).pixels()) lost += pixel[0] == 0 ? 1 : 0;
      ++frames;
    }
  }
  CHECK(frames > 500);
  CHECK(lost == 0);
}

TEST_CASE("what pulls a membrane that does not clip to rest pulls it wherever it plugs in") {
  const Camera<float> eye{60, 60, 29.5F, 23.5F, 60, 48};
  const Image<float> rest(60, 48, 0.03F);
  Image<float> depth = rest;
  for (Index y = 20; y < 27; ++y) std::fill_n(depth.row(y) + 25, 8, 0.031F);
  depth(50, 40) = 1e30F;  // out of the range of depths: it does not pull
  const GaussianMembrane<float> pulled(2, 6, false);
  const auto check = [&](const auto& membrane, bool is_pulled) {
    const TactileRenderer sensor(eye, rest, membrane, NormalMap{});
    const TactileRenderer whole(eye, rest, membrane, NormalMap{}, {.skip_unchanged = false});
    auto frame = sensor.rest_frame();
    sensor.render_next_into(frame, depth);
    CHECK(frame.image == sensor.render(depth));
    CHECK(frame.image == whole.render(depth));
    CHECK((frame.image != sensor.rest_image()) == is_pulled);
    return frame.image;
  };
  const Image<Rgb8> own = check(pulled, true);
  const Image<Rgb8> plugged = check(Plugged(2, 6, false), true);
  for (std::size_t i = 0; i < own.pixels().size(); ++i) {
    for (std::size_t k = 0; k < 3; ++k) {
      CHECK(std::abs(int{own.pixels()[i][k]} - int{plugged.pixels()[i][k]}) <= 1);
    }
  }
  // Nothing touches, so that nothing is hidden.
  CHECK(check(ShadowedMembrane<float>(eye, pulled), true) == plugged);
  check(Plugged(2, 6, true), false);
  check(ShadowedMembrane<float>(eye, GaussianMembrane<float>(2, 6)), false);
}
