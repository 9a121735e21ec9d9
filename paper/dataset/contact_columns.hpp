// Columns that are single contacts of a scene under single loads: which contact and load a column is, and its
// truth. What is seen of them, the derived classes say.
#pragma once

#include "core/contact/scene.hpp"
#include "core/numeric/random.hpp"
#include "paper/dataset/column_source.hpp"
#include "paper/dataset/dataset.hpp"

namespace slipd {

// Which contacts of the scene's endless row of them, under which loads.
struct FrameChoice {
  std::size_t first_contact = 0;
  DataSetSize size;
  bool random_loads = false;  // Gamma uniform in [0, 1) instead of in even steps
};

// Column j is contact first_contact + j / loads under load j % loads.
class ContactColumns : public ColumnSource {
 public:
  std::size_t columns() const noexcept final { return choice_.size.columns(); }
  double gamma(std::size_t column) const;
  double friction(std::size_t column) const;

 protected:
  ContactColumns(Scene scene, std::uint64_t seed, const FrameChoice& choice);

  std::size_t contact(std::size_t column) const noexcept {
    return choice_.first_contact + column / choice_.size.loads;
  }
  RandomStream noise(std::size_t column) const noexcept;

  Scene scene_;
  std::uint64_t seed_;
  FrameChoice choice_;
};

}  // namespace slipd
