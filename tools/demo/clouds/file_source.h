// Clouds from files as a source. They are published one after the other, again and again.
#pragma once

#include "tools/demo/clouds/point_cloud_files.h"

namespace sft::demo {

class FileSource final : public CloudSource {
 public:
  /// REQUIRES: there is at least one cloud.
  FileSource(std::string name, std::vector<InputCloud> clouds)
      : name_(std::move(name)), clouds_(std::move(clouds)) {}

  std::string name() const override { return name_; }
  std::string shape() const override;
  Result<Published> publish(Publisher<PointCloud2>& publisher, std::uint64_t number) override;

 private:
  const std::string name_;
  const std::vector<InputCloud> clouds_;
};

}  // namespace sft::demo
