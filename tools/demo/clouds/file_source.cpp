#include <algorithm>

#include "tools/demo/clouds/input_cloud.h"

namespace sft::demo {

namespace {

class FileSource final : public CloudSource {
 public:
  FileSource(std::string name, std::vector<InputCloud> clouds)
      : name_(std::move(name)), clouds_(std::move(clouds)) {}

  std::string name() const override { return name_; }
  std::string shape() const override {
    const std::string& first = clouds_.front().shape;
    const bool alike =
        std::all_of(clouds_.begin(), clouds_.end(), [&](const InputCloud& c) { return c.shape == first; });
    return alike ? first : "clouds of several sizes";
  }
  Result<Published> publish(Publisher<PointCloud2>& publisher, std::uint64_t number) override {
    const std::vector<std::byte>& payload = clouds_[number % clouds_.size()].payload;
    return publisher.publish_cdr(payload).map([&](PublishStatus status) {
      return Published{status, payload.size()};
    });
  }

 private:
  const std::string name_;
  const std::vector<InputCloud> clouds_;
};

}  // namespace

std::unique_ptr<CloudSource> file_source(std::string name, std::vector<InputCloud> clouds) {
  return std::make_unique<FileSource>(std::move(name), std::move(clouds));
}

}  // namespace sft::demo
