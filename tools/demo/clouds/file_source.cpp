#include "tools/demo/clouds/file_source.h"

#include <algorithm>

namespace sft::demo {

std::string FileSource::shape() const {
  const std::string& first = clouds_.front().shape;
  const bool alike =
      std::all_of(clouds_.begin(), clouds_.end(), [&](const InputCloud& c) { return c.shape == first; });
  return alike ? first : "clouds of several sizes";
}

Result<CloudSource::Published> FileSource::publish(Publisher<PointCloud2>& publisher, std::uint64_t number) {
  const std::vector<std::byte>& payload = clouds_[number % clouds_.size()].payload;
  return publisher.publish_cdr(payload).map([&](PublishStatus status) {
    return Published{status, payload.size()};
  });
}

}  // namespace sft::demo
