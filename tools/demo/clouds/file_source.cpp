#include "tools/demo/clouds/file_source.h"

#include <algorithm>

namespace sft::demo {

namespace {

Result<CloudSource::Published> publish_encoded(Publisher<PointCloud2>& publisher, const EncodedCloud& cloud) {
  return publisher.publish_cdr(cloud.payload).map([&](PublishStatus status) {
    return CloudSource::Published{status, cloud.payload.size()};
  });
}

Result<CloudSource::Published> publish_converted(Publisher<PointCloud2>& publisher,
                                                 const ConvertedCloud& cloud) {
  const auto data_bytes = static_cast<std::uint32_t>(cloud.data.size());
  Result<Loan<PointCloud2>> loan = publisher.loan_for_overwrite(cloud.prototype, {.data = data_bytes});
  if (!loan) return tl::unexpected(loan.error());
  std::copy(cloud.data.begin(), cloud.data.end(), (*loan)->data().begin());
  return CloudSource::Published{std::move(*loan).publish(), full_bytes(cloud.prototype, data_bytes)};
}

}  // namespace

std::string FileSource::shape() const {
  const std::string first = shape_of(clouds_.front());
  const bool alike =
      std::all_of(clouds_.begin(), clouds_.end(), [&](const InputCloud& c) { return shape_of(c) == first; });
  return alike ? first : "clouds of several sizes";
}

Result<CloudSource::Published> FileSource::publish(Publisher<PointCloud2>& publisher, std::uint64_t number) {
  const InputCloud& cloud = clouds_[number % clouds_.size()];
  if (const auto* encoded = std::get_if<EncodedCloud>(&cloud)) return publish_encoded(publisher, *encoded);
  return publish_converted(publisher, std::get<ConvertedCloud>(cloud));
}

}  // namespace sft::demo
