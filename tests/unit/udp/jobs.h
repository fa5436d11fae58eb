// Functions that make jobs as a publisher does.
#pragma once

#include <memory>

#include "tests/unit/udp/messages.h"
#include "udp_transport/outgoing/job.h"

namespace sft::udp::test {

/// Returns a job with an encoded image. The job does not refer to the memory of the image.
inline JobHandle make_job(JobPool& jobs, std::uint64_t sequence, std::size_t data_bytes = 100) {
  const auto memory = core::BufferPool::make(std::size_t{1} << 20);
  const Image image = make_image(data_bytes);
  const FieldMask all = fields<Image>("*");
  const core::SampleHandle sample = memory->take(sample_bytes(image, all));
  fill(*sample, image, all, 1, sequence);
  JobHandle job = jobs.take();
  const TypeSupport& type = type_support<Image>();
  job->mask = std::make_shared<WireMask>(WireMask{0, all.hash(), {}});
  job->projection.project(core::state_of(*sample, type.index_slots()), type.type(), all);
  job->sequence = sequence;
  job->first = {};
  job->first.label = {1, static_cast<std::uint32_t>(sequence), 0};
  job->first.total = static_cast<std::uint32_t>(job->projection.bytes());
  job->copy_body();
  return job;
}

}  // namespace sft::udp::test
