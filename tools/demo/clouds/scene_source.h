// The generated scene as a source of clouds. Each cloud is computed where its readers will read it, in memory
// that the publisher lends.
#pragma once

#include "tools/demo/clouds/cloud_source.h"
#include "tools/demo/clouds/scene.h"

namespace sft::demo {

class SceneSource final : public CloudSource {
 public:
  /// `hz` tells how much time lies between two clouds.
  explicit SceneSource(double hz);

  std::string name() const override { return "generated scene"; }
  std::string shape() const override { return format_shape(Scene::rows, Scene::columns); }
  Result<Published> publish(Publisher<PointCloud2>& publisher, std::uint64_t number) override;

 private:
  const double hz_;
  const Scene scene_;
  PointCloud2 prototype_;  // all but the points
};

}  // namespace sft::demo
