#include "bench/selection/local_part.h"

#include <algorithm>
#include <cstring>

namespace sft::bench {

namespace {

core::SampleHandle sample_of(const Sample& whole, core::BufferPool& pool, const TypeSupport& type) {
  const detail::SampleLayout layout(type.index_slots());
  const detail::SampleState& state = whole.state();
  core::SampleHandle sample = pool.take(layout.bytes(state.body_bytes));
  std::memcpy(sample->data + layout.body_offset, state.body, state.body_bytes);
  std::copy_n(state.index, type.index_slots(), sample->index());
  sample->header().body_bytes = state.body_bytes;
  sample->mask = type.full();
  return sample;
}

}  // namespace

LocalPart::LocalPart(const TypeSupport& type, const Sample& whole, std::string_view selection)
    : copies_(core::RemoteCopy::make(type, pool_)),
      asked_(core::make_asked(type, type.closed(type.parse_selection(selection).value()), false, nullptr)),
      sample_(sample_of(whole, *pool_, type)),
      part_(copies_->in_place(sample_, asked_)),
      state_(copies_->state(*part_.sample)) {
  state_.parts = part_.parts;
}

LocalPart::~LocalPart() { core::PartReader::end(part_.parts); }

void LocalPart::take_and_release() { core::PartReader::end(copies_->in_place(sample_, asked_).parts); }

}  // namespace sft::bench
