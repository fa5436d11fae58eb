#include "core/subscribe/vanilla_inlet.h"

#include <algorithm>
#include <limits>
#include <utility>

#include "core/platform/clock.h"

namespace sft::core {

namespace {

constexpr std::uint64_t gap_max = 1 << 30;  // a longer gap of the sequence is none of lost samples

}  // namespace

/// Lends buffers that refer to the memory of samples which several readers share. Each reader needs a buffer
/// of its own, since buffers name the gate that the sample has passed, and where readers have found elements.
class VanillaInlet::Lender final : public BufferOwner, public std::enable_shared_from_this<Lender> {
 public:
  explicit Lender(const TypeSupport& type) : type_(type) {}

  /// A sample without a stamp has the time of its arrival instead. Without a time it would have expired, and
  /// a maximum rate would let no later one pass.
  SampleHandle lend(const VanillaArrival& arrival) {
    SampleBuffer& buffer = take();
    const SampleBuffer& whole = *arrival.sample;
    buffer.receive_stamp_ns = realtime_ns();
    buffer.origin() = {
        .writer = arrival.writer,
        .source_stamp_ns = arrival.source_stamp_ns > 0 ? arrival.source_stamp_ns : buffer.receive_stamp_ns};
    buffer.data = whole.data;
    buffer.capacity = whole.capacity;
    buffer.owner_data = SampleHandle(arrival.sample).release();
    buffer.owner = shared_from_this();
    return SampleHandle(buffer);
  }
  void recycle(SampleBuffer& buffer) noexcept override {
    const SampleHandle whole =
        SampleHandle::adopt(static_cast<SampleBuffer*>(std::exchange(buffer.owner_data, nullptr)));
    const Lock lock(mutex_);
    free_.push_back(&buffer);
  }

 private:
  SampleBuffer& take() {
    const Lock lock(mutex_);
    if (free_.empty()) {
      free_.reserve(all_.size() + 1);  // so that returning a buffer allocates nothing
      SampleBuffer& made = all_.emplace_back();
      made.mask = type_.full();
      return made;
    }
    SampleBuffer& buffer = *free_.back();
    free_.pop_back();
    return buffer;
  }

  const TypeSupport& type_;
  Mutex mutex_ SFT_ACQUIRED_AFTER(lock_order::jobs);
  std::deque<SampleBuffer> all_ SFT_GUARDED_BY(mutex_);
  std::vector<SampleBuffer*> free_ SFT_GUARDED_BY(mutex_);
};

VanillaInlet::VanillaInlet(const TypeSupport& type, std::uint32_t depth, std::uint64_t depth_bytes)
    : type_(type), depth_(depth), depth_bytes_(depth_bytes), lender_(std::make_shared<Lender>(type)) {}

VanillaInlet::~VanillaInlet() = default;

/// Drops a retained sample that has come to an earlier DDS reader of the subscriber. A sample with such a
/// sequence and a later stamp is new: its writer has restarted under its old name, and counts from 1 again.
bool VanillaInlet::put(const VanillaArrival& arrival) {
  SampleHandle sample = arrival.sample ? lender_->lend(arrival) : SampleHandle();
  const Lock lock(mutex_);
  Writer* const writer = writer_of(arrival.writer);
  if (writer == nullptr || !sample) {
    ++counters_.discarded;
    if (writer != nullptr) ++(writer->waiting.empty() ? writer->discarded : writer->discarded_behind);
    return false;
  }
  sample->sequence = arrival.sequence == 0 ? writer->last + 1 : arrival.sequence;
  if (sample->sequence <= writer->last) {
    if (arrival.source_stamp_ns <= writer->last_stamp_ns) return false;
  } else if (writer->last != 0) {
    const std::uint64_t gap = sample->sequence - writer->last - 1;
    writer->missing += static_cast<std::uint32_t>(std::min<std::uint64_t>(gap, gap_max));
  }
  writer->last = sample->sequence;
  writer->last_stamp_ns = arrival.source_stamp_ns;
  ++writer->arrivals;
  if (writer->gate != nullptr && !passes(*writer, *sample, type_.index_slots())) return false;
  enqueue(*writer, std::move(sample));
  return true;
}

bool VanillaInlet::passes(Writer& writer, SampleBuffer& sample, std::size_t slots) {
  Gate& gate = *writer.gate;
  const detail::SampleState state = state_of(sample, slots);
  const detail::FieldSource fields = detail::FieldSource::of_sample(state);
  gate.consider(fields, sample.source_stamp_ns);
  if (!gate.passes()) return false;
  gate.made(fields, sample.source_stamp_ns);
  sample.gate = gate.id();
  sample.min_period_us = gate.min_period_us();
  sample.ordinal = gate.ordinal() + writer.missing;
  return true;
}

void VanillaInlet::enqueue(Writer& writer, SampleHandle sample) {
  writer.bytes += sample->header().body_bytes;
  writer.waiting.push_back({std::move(sample), ++arrivals_, std::exchange(writer.discarded_behind, 0)});
  while (are_too_many(writer.waiting.size(), writer.bytes)) discard_oldest(writer);
}

void VanillaInlet::discard_oldest(Writer& writer) {
  writer.bytes -= writer.waiting.front().sample->header().body_bytes;
  writer.waiting.pop_front();
  ++counters_.discarded;
  writer.discarded += 1 + writer.take_discarded_before_next();
}

SampleHandle VanillaInlet::take() {
  const Lock lock(mutex_);
  Writer* first = nullptr;
  for (auto& [id, writer] : writers_) {
    if (writer.waiting.empty()) continue;
    if (first == nullptr || writer.waiting.front().arrival < first->waiting.front().arrival) first = &writer;
  }
  if (first == nullptr) return {};
  SampleHandle sample = std::move(first->waiting.front().sample);
  first->waiting.pop_front();
  first->bytes -= sample->header().body_bytes;
  // Gaps in the sequence show what was discarded later, but not what was discarded before the first sample.
  if (!std::exchange(first->was_taken, true)) {
    first->lost_before_first = first->discarded;
    counters_.lost_unnoticed += first->discarded;
  }
  first->discarded = first->take_discarded_before_next();
  if (first->is_gone && first->waiting.empty())
    counters_.lost_unnoticed += std::exchange(first->discarded, 0);  // no later sample shows them
  return sample;
}

void VanillaInlet::ask(const Selection& selection, std::uint32_t min_period_us) {
  const Lock lock(mutex_);
  const bool is_same =
      min_period_us == min_period_us_ && selection.gate().conditions == asked_.gate().conditions;
  asked_ = selection;
  min_period_us_ = min_period_us;
  if (is_same) return;
  for (auto& [id, writer] : writers_) writer.gate = make_gate();
}

std::unique_ptr<Gate> VanillaInlet::make_gate() const {
  const std::vector<Selection::Condition>& conditions = asked_.gate().conditions;
  if (conditions.empty()) return min_period_us_ == 0 ? nullptr : std::make_unique<Gate>(min_period_us_);
  auto gate = std::make_unique<Gate>(min_period_us_, detail::Conditions(type_.type(), conditions),
                                     asked_.gate_hash());
  gate->reader_begins();
  return gate;
}

VanillaInlet::Writer* VanillaInlet::writer_of(EndpointId id) {
  const auto known = writers_.find(id);
  if (known != writers_.end()) return &known->second;
  if (writers_.size() >= writers_max) return nullptr;
  return &writers_.emplace(id, Writer{.gate = make_gate()}).first->second;
}

void VanillaInlet::forget_others_than(std::span<const EndpointId> writers) {
  const auto is_gone = [&](EndpointId id) { return std::ranges::find(writers, id) == writers.end(); };
  const Lock lock(mutex_);
  std::vector<Writer*> gone;
  for (auto& [id, writer] : writers_) {
    writer.is_gone = is_gone(id);
    if (writer.is_gone && !writer.waiting.empty()) gone.push_back(&writer);
  }
  discard_surplus(gone);
  for (auto next = writers_.begin(); next != writers_.end();) {
    const auto here = next++;
    const Writer& writer = here->second;
    if (!writer.waiting.empty() || !writer.is_gone) continue;
    counters_.lost_unnoticed += writer.discarded;  // no later sample shows them
    writers_.erase(here);
  }
}

void VanillaInlet::discard_surplus(std::span<Writer* const> gone) {
  std::size_t samples = 0;
  std::uint64_t bytes = 0;
  for (const Writer* writer : gone) {
    samples += writer->waiting.size();
    bytes += writer->bytes;
  }
  const auto oldest = [](const Writer* writer) {
    return writer->waiting.empty() ? std::numeric_limits<std::uint64_t>::max()
                                   : writer->waiting.front().arrival;
  };
  for (; are_too_many(samples, bytes); --samples) {
    Writer& writer = **std::ranges::min_element(gone, {}, oldest);
    const std::uint64_t before = writer.bytes;
    discard_oldest(writer);
    bytes -= before - writer.bytes;
  }
}

std::uint64_t VanillaInlet::arrivals(EndpointId writer) const {
  const Lock lock(mutex_);
  const auto known = writers_.find(writer);
  return known == writers_.end() ? 0 : known->second.arrivals;
}

std::uint64_t VanillaInlet::lost_before_first(EndpointId writer) const {
  const Lock lock(mutex_);
  const auto found = writers_.find(writer);
  if (found == writers_.end()) return 0;
  return found->second.was_taken ? found->second.lost_before_first : found->second.discarded;
}

ReaderPort::Counters VanillaInlet::counters() const {
  const Lock lock(mutex_);
  return counters_;
}

}  // namespace sft::core
