#pragma once

#include <mujoco/mujoco.h>

#include <array>
#include <cmath>
#include <iomanip>
#include <memory>
#include <numbers>
#include <sstream>
#include <stdexcept>
#include <string>

#include "gelight/image/raster.hpp"
#include "gelight/mesh/shapes.hpp"

// MuJoCo's worlds, and what they are told in its own XML.

/// A mesh as an asset. MuJoCo collides its convex hull.
[[nodiscard]] inline std::string mesh_asset(const std::string& name,
                                            const gelight::Mesh<double>& mesh) {
  std::ostringstream xml;
  const auto write = [&](const auto& rows) {
    for (const auto& [a, b, c] : rows) xml << a << ' ' << b << ' ' << c << ' ';
  };
  xml << "<mesh name='" << name << "' vertex='";
  write(mesh.positions);
  xml << "' face='";
  write(mesh.faces);
  xml << "'/>";
  return xml.str();
}

/// A ring about the z axis that lies on z = 0, of straight bars, for its hull would be a disc. They
/// share the load, and are the softer for it.
[[nodiscard]] inline std::string ring_of_bars(double major_radius, double minor_radius) {
  constexpr int bars = 24;
  constexpr double step = 2 * std::numbers::pi / bars;
  std::ostringstream xml;
  for (int i = 0; i < bars; ++i) {
    xml << "<geom type='capsule' priority='1' solimp='0.2 0.2 0.001' size='" << minor_radius
        << "' fromto='";
    for (const double angle : {i * step, (i + 1) * step}) {
      xml << major_radius * std::cos(angle) << ' ' << major_radius * std::sin(angle) << ' '
          << minor_radius << ' ';
    }
    xml << "'/>";
  }
  return xml.str();
}

/// A force to a tenth, such as 3.2 N.
[[nodiscard]] inline std::string in_newtons(double force) {
  std::ostringstream words;
  words << std::fixed << std::setprecision(1) << force << " N";
  return words.str();
}

/// A MuJoCo model from a file, and its state.
class MujocoWorld {
 public:
  explicit MujocoWorld(const std::string& path) {
    std::array<char, 500> error{};
    model_.reset(mj_loadXML(path.c_str(), nullptr, error.data(), error.size()));
    if (!model_) throw std::runtime_error(path + ": " + error.data());
    data_.reset(mj_makeData(model_.get()));
  }

  /// MuJoCo's arrays: joints' positions (`qpos`), actuators' wishes (`ctrl`) and all the rest.
  [[nodiscard]] mjData& state() const { return *data_; }

  void step() { mj_step(model_.get(), data_.get()); }

  /// Where the body is that the file names last.
  [[nodiscard]] gelight::Pose last_body() const {
    const int body = model_->nbody - 1;
    using Rows = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;
    return {Eigen::Map<const Rows>(data_->xmat + 9 * body),
            Eigen::Map<const gelight::Vec3<double>>(data_->xpos + 3 * body)};
  }

  /// The sum of all contact forces as those of one body on the other, in newtons.
  [[nodiscard]] gelight::Vec3<double> contact_force() const {
    gelight::Vec3<double> sum = gelight::Vec3<double>::Zero();
    for (int i = 0; i < data_->ncon; ++i) {
      std::array<mjtNum, 6> force{};  // along the contact's axes, then the torque
      mj_contactForce(model_.get(), data_.get(), i, force.data());
      const mjtNum* axes = data_->contact[i].frame;  // a row each
      for (Eigen::Index k = 0; k < 3; ++k) {
        sum += force[static_cast<std::size_t>(k)] *
               Eigen::Map<const gelight::Vec3<double>>(axes + 3 * k);
      }
    }
    return sum;
  }

 private:
  std::unique_ptr<mjModel, decltype(&mj_deleteModel)> model_{nullptr, mj_deleteModel};
  std::unique_ptr<mjData, decltype(&mj_deleteData)> data_{nullptr, mj_deleteData};
};
