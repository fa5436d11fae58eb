#include "tests/simulation/udp/publisher.h"

#include <chrono>
#include <utility>

namespace sft::simulation {

void Publisher::publish(const std::map<core::EndpointId, Mask>& asked, Time now) {
  std::set<Mask> served;
  for (const auto& [reader, mask] : asked) served.insert(mask);
  FieldMask all = image_type().none();
  for (const Mask mask : served) all |= masks()[mask];
  std::vector<Image> images = next_images(served.size() == 1 && !group_.exists());
  if (group_.exists()) {
    publish_to_group(images.front(), served, all, now);
  } else {
    for (const Mask mask : served)
      channel_.keep(encode(images, masks()[mask], static_cast<std::uint16_t>(mask)));
  }
  for (Image& image : images) {
    for (const auto& [reader, mask] : asked)
      laws_.owes(reader, {sequence_, (group_.exists() ? all : masks()[mask]).hash()});
    laws_.published(sequence_++, std::move(image), now);
  }
  const bool is_last = ++published_ == scenario_.samples;
  publish_at_ = is_last ? Time::max() : now + std::chrono::microseconds(log_uniform(random_, 20'000));
  channel_.wake(now);
}

/// `may_span`: there may be several images, which are small then.
std::vector<Image> Publisher::next_images(bool may_span) {
  const bool is_span = may_span && happens(random_, scenario_.span);
  const double bytes_max = is_span ? 200 : static_cast<double>(scenario_.sample_bytes_max);
  std::vector<Image> images;
  for (std::size_t left = is_span ? from_to(random_, 2, 40) : 1; left > 0; --left) {
    const auto seed = static_cast<std::uint32_t>((sequence_ + images.size()) * 7);
    images.push_back(udp::test::make_image(log_uniform(random_, bytes_max), seed));
  }
  return images;
}

/// Publishes the image once, under all masks of the process.
void Publisher::publish_to_group(const Image& image, const std::set<Mask>& served, const FieldMask& all,
                                 Time now) {
  if (served.empty()) return;
  std::uint16_t masks_served = 0;  // a bit for each
  for (const Mask mask : served) masks_served |= static_cast<std::uint16_t>(1U << mask);
  const udp::JobHandle job = encode({&image, 1}, all, static_cast<std::uint16_t>(100 + masks_served));
  job->first.flags |= udp::merged_masks;
  group_.send(job, now);
}

/// Several images become a pack.
udp::JobHandle Publisher::encode(std::span<const Image> images, const FieldMask& mask,
                                 std::uint16_t variant) {
  const FieldMask all = image_type().full();
  udp::JobHandle job = jobs_->take();
  job->mask = std::make_shared<udp::WireMask>(udp::WireMask{variant, mask.hash(), {}});
  job->sequence = sequence_;
  job->first.label = {writer_label, static_cast<std::uint32_t>(sequence_), variant};
  job->first.flags = 0;
  job->first.mask = job->mask->mask;
  for (const Image& image : images) {
    core::SampleHandle sample = memory_->take(udp::test::sample_bytes(image, all));
    udp::test::fill(*sample, image, all, writer_id, sequence_);
    project(*job, sample, mask, images.size() > 1);
  }
  if (images.size() > 1) job->seal();
  return job;
}

void Publisher::project(udp::Job& job, const core::SampleHandle& sample, const FieldMask& mask, bool packed) {
  job.projection.project(core::state_of(*sample, image_type().slots()), image_type().type(), mask);
  if (packed) return job.pack(job.projection.segments());
  job.first.total = static_cast<std::uint32_t>(job.projection.bytes());
  if (happens(random_, 0.5)) {
    job.copy_body();
  } else {
    job.sample = sample;
  }
}

}  // namespace sft::simulation
