// SVD and nearest neighbours (docs/methods.md §26): alpha on the sensor's own grid, projected on the
// few bases that explain most of the scene's contacts, answered by the nearest of them. Bound to where the
// training had its contacts: a scene with room for offset costs it most of its accuracy. With a model of
// rings it is the registered estimator: the contact is brought into a frame of its own first, and place, size
// and force drop out.
#pragma once

#include <memory>
#include <vector>

#include "core/reading/method/method.hpp"
#include "core/reading/moments/moments.hpp"
#include "paper/model/model.hpp"

namespace slipd {

class SvdKnn final : public SlipMethod {
 public:
  // precision: in which a point's coordinates are added up; the points themselves are single.
  explicit SvdKnn(std::shared_ptr<const Model> model, Precision precision = Precision::single_precision);
  MethodSettings settings() const noexcept override;
  Method name() const noexcept override {
    return model_->setup().view == View::rings ? Method::registered : Method::svd_knn;
  }

  // slipd's code allocates nothing; FLANN makes one small array (see Neighbours::Query::find).
  Reading estimate(const Frame& frame, const ContactPatch& patch) noexcept override;

 private:
  // Fills point_; returns whether it lies where the training's contacts did. `noise` gets the standard
  // deviation of each of its coordinates that comes of the frame's shear noise, rad.
  template <class Real>
  bool project_rings(const ContactPatch& patch, const Rings& all, float& noise) noexcept;
  template <class Real>
  bool project(const ContactPatch& patch, float& noise) noexcept;
  template <class Real>
  void project_angles(const ContactPatch& patch) noexcept;  // alpha_ → point_
  template <class Real>
  std::vector<Real>& sums() noexcept;

  std::shared_ptr<const Model> model_;
  Neighbours::Query query_;
  Moments moments_;           // whether the load has only risen: a question that needs no model
  std::vector<float> alpha_;  // of every taxel
  std::vector<float> point_;  // rank
  std::vector<double> point_double_;
  Precision precision_;
};

}  // namespace slipd
