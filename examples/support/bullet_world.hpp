#pragma once

#include <LinearMath/btConvexHullComputer.h>
#include <btBulletDynamicsCommon.h>

#include <memory>
#include <vector>

#include "gelight/core/types.hpp"
#include "gelight/mesh/shapes.hpp"
#include "household.hpp"

// A world of the Bullet engine with one thing in it.

/// What the gel bears.
struct BulletContact {
  double force = 0;                                              // N, upwards
  gelight::Vec2<double> centre = gelight::Vec2<double>::Zero();  // m
};

/// A thing in Bullet's world, above a flat, rigid gel. The camera looks up from the origin at the
/// gel, z upwards.
class BulletWorld {
 public:
  static constexpr double gel_depth = 0.07, gravity = 9.81;  // m, m/s^2
  static constexpr int frames_a_second = 60;                 // of the camera

  explicit BulletWorld(const Thing& thing)
      : dispatcher_(&configuration_),
        world_(&dispatcher_, &broadphase_, &solver_, &configuration_),
        gel_box_(btVector3(30, 30, 1)),
        centre_(centre_of_area(thing.mesh)),
        hull_(hull_about(thing.mesh, centre_)) {
    world_.setGravity(to_bullet({0, 0, -gravity}));
    world_.getSolverInfo().m_numIterations = 200;
    const btTransform below(btQuaternion::getIdentity(), to_bullet({0, 0, gel_depth - centimetre}));
    gel_state_ = std::make_unique<btDefaultMotionState>(below);
    gel_ = std::make_unique<btRigidBody>(
        btRigidBody::btRigidBodyConstructionInfo(0, gel_state_.get(), &gel_box_));
    gel_->setFriction(0.6f);
    gel_->setRollingFriction(0.01f);
    world_.addRigidBody(gel_.get());

    btVector3 inertia;
    const auto mass = static_cast<btScalar>(thing.mass);
    hull_->calculateLocalInertia(mass, inertia);
    const double drop = 0.006;
    const btQuaternion lean(btVector3(1, 0, 0), 0.06f), turn(btVector3(0, 0, 1), -0.5f);
    const btQuaternion lying = lean * turn;
    const btTransform start(
        lying, to_bullet({0, 0, gel_depth + drop}) + btMatrix3x3(lying) * to_bullet(centre_));
    state_ = std::make_unique<btDefaultMotionState>(start);
    body_ = std::make_unique<btRigidBody>(
        btRigidBody::btRigidBodyConstructionInfo(mass, state_.get(), hull_.get(), inertia));
    body_->setFriction(0.6f);
    body_->setRollingFriction(0.01f);
    body_->setDamping(0.1f, 0.5f);
    body_->setActivationState(DISABLE_DEACTIVATION);
    world_.addRigidBody(body_.get());
  }

  ~BulletWorld() {
    world_.removeRigidBody(body_.get());
    world_.removeRigidBody(gel_.get());
  }
  BulletWorld(const BulletWorld&) = delete;
  BulletWorld& operator=(const BulletWorld&) = delete;

  /// Until the camera's next frame, under a force (N) at the centre of mass.
  void step(const gelight::Vec3<double>& push) {
    for (int i = 0; i < steps_a_frame; ++i) {
      body_->applyCentralForce(to_bullet(push));
      world_.stepSimulation(static_cast<btScalar>(time_step), 0);
    }
  }

  /// What the gel bears in the last step.
  [[nodiscard]] BulletContact contact() const {
    BulletContact contact;
    for (int i = 0; i < dispatcher_.getNumManifolds(); ++i) {
      const btPersistentManifold& manifold = *dispatcher_.getManifoldByIndexInternal(i);
      for (int k = 0; k < manifold.getNumContacts(); ++k) {
        const btManifoldPoint& point = manifold.getContactPoint(k);
        const double force = point.getAppliedImpulse() / time_step * centimetre;
        const btVector3& at = point.getPositionWorldOnB();
        contact.force += force;
        contact.centre += force * centimetre * gelight::Vec2<double>(at.x(), at.y());
      }
    }
    if (contact.force > 0) contact.centre /= contact.force;
    return contact;
  }

  [[nodiscard]] bool is_still() const {
    return body_->getLinearVelocity().length() < 0.05 &&
           body_->getAngularVelocity().length() < 0.02;
  }

  /// In m/s.
  [[nodiscard]] double speed() const {
    return centimetre * double{body_->getLinearVelocity().length()};
  }

  [[nodiscard]] gelight::Vec2<double> centre_of_mass() const {
    const btVector3& at = body_->getCenterOfMassPosition();
    return centimetre * gelight::Vec2<double>(at.x(), at.y());
  }

  /// The thing where it is now, `sunk` metres lower.
  [[nodiscard]] gelight::Mesh<double> placed(const gelight::Mesh<double>& mesh, double sunk) const {
    const btTransform& pose = body_->getCenterOfMassTransform();
    Eigen::Matrix3d rotation;
    gelight::Vec3<double> move;
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 3; ++j) rotation(i, j) = pose.getBasis()[i][j];
      move[i] = centimetre * pose.getOrigin()[i];
    }
    move -= rotation * centre_ + gelight::Vec3<double>(0, 0, sunk);
    return gelight::placed<double>(mesh, rotation, move);
  }

 private:
  // Bullet is made for things of about a metre: it gets centimetres, and with them forces in
  // kg cm / s^2.
  static constexpr double centimetre = 0.01;
  static constexpr int steps_a_frame = 8;
  static constexpr double time_step = 1.0 / (frames_a_second * steps_a_frame);

  [[nodiscard]] static btVector3 to_bullet(const gelight::Vec3<double>& v) {
    return {static_cast<btScalar>(v.x() / centimetre), static_cast<btScalar>(v.y() / centimetre),
            static_cast<btScalar>(v.z() / centimetre)};
  }

  /// Of a thing of thin sheet or wire: of its faces.
  [[nodiscard]] static gelight::Vec3<double> centre_of_area(const gelight::Mesh<double>& mesh) {
    gelight::Vec3<double> sum = gelight::Vec3<double>::Zero();
    double area = 0;
    for (const auto& [a, b, c] : mesh.faces) {
      const auto at = [&](gelight::Index v) {
        return gelight::Vec3<double>(mesh.position(v).data());
      };
      const double twice = gelight::cross<double>(at(b) - at(a), at(c) - at(a)).norm();
      sum += twice / 3 * (at(a) + at(b) + at(c));
      area += twice;
    }
    return sum / area;
  }

  /// On a flat gel a thing touches where its convex hull does.
  [[nodiscard]] static std::unique_ptr<btConvexHullShape> hull_about(
      const gelight::Mesh<double>& mesh, const gelight::Vec3<double>& centre) {
    std::vector<btVector3> points;
    for (const auto& p : mesh.positions)
      points.push_back(to_bullet(gelight::Vec3<double>(p.data()) - centre));
    btConvexHullComputer computer;
    computer.compute(&points[0].m_floats[0], sizeof(btVector3), static_cast<int>(points.size()), 0,
                     0);
    auto hull = std::make_unique<btConvexHullShape>();
    for (int i = 0; i < computer.vertices.size(); ++i) hull->addPoint(computer.vertices[i], false);
    hull->recalcLocalAabb();
    hull->setMargin(0.001f);
    return hull;
  }

  btDefaultCollisionConfiguration configuration_;
  btCollisionDispatcher dispatcher_;
  btDbvtBroadphase broadphase_;
  btSequentialImpulseConstraintSolver solver_;
  mutable btDiscreteDynamicsWorld world_;
  btBoxShape gel_box_;
  gelight::Vec3<double> centre_;
  std::unique_ptr<btConvexHullShape> hull_;
  std::unique_ptr<btDefaultMotionState> gel_state_, state_;
  std::unique_ptr<btRigidBody> gel_, body_;
};
