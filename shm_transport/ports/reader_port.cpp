#include "shm_transport/ports/reader_port.h"

#include <algorithm>

#include "core/platform/clock.h"
#include "shm_transport/host/queue_room.h"

namespace sft::shm {

using core::SampleBuffer;
using core::SampleHandle;

std::shared_ptr<ChunkBorrower> ChunkBorrower::make(std::shared_ptr<Session> session,
                                                   iox::popo::SubscriberPortData& port,
                                                   core::EndpointId writer, const TypeSupport& type,
                                                   std::shared_ptr<Statistics> statistics,
                                                   std::uint32_t held_limit, const QueueWishes& wishes) {
  std::shared_ptr<ChunkBorrower> borrower(
      new ChunkBorrower(session, port, writer, type, std::move(statistics), held_limit, wishes));
  session->enlist(borrower);
  return borrower;
}

ChunkBorrower::ChunkBorrower(std::shared_ptr<Session> session, iox::popo::SubscriberPortData& port,
                             core::EndpointId writer, const TypeSupport& type,
                             std::shared_ptr<Statistics> statistics, std::uint32_t held_limit,
                             const QueueWishes& wishes)
    : session_(std::move(session)),
      writer_(writer),
      type_(type),
      statistics_(std::move(statistics)),
      retained_first_(wishes.late),
      is_awaited_(wishes.awaited),
      is_deepest_(wishes.deepest),
      queue_(port, held_limit, type.full()) {}

/// Runs only after all samples were given back. The session gives the port back to the daemon as soon as no
/// writer delivers to the port any more.
ChunkBorrower::~ChunkBorrower() {
  close();
  while (queue_.drop_oldest()) {
  }
  session_->retire(&queue_.port());
}

bool ChunkBorrower::connected() noexcept {
  if (!open()) return false;
  if (feeder_ == nullptr || !Session::feeds(*feeder_, queue_.port()))
    feeder_ = session_->feeder_of(queue_.port());
  return feeder_ != nullptr;
}

SampleHandle ChunkBorrower::take() noexcept {
  for (;;) {
    const ChunkQueue::Taken taken = queue_.take();
    if (taken.limit_reached) count_held_too_many();
    if (taken.slot == nullptr) return {};
    after_chunk_came();
    if (taken.overflowed) losses_.overflowed();
    if (is_awaited_ && QueueRoom(queue_.port()).is_waited_for())
      owes_wake_.store(true, std::memory_order_relaxed);
    SampleBuffer& buffer = taken.slot->buffer;
    if (!check(*taken.slot, taken.popped)) {
      recycle(buffer);
      continue;
    }
    buffer.receive_stamp_ns = core::realtime_ns();
    buffer.owner = shared_from_this();
    return SampleHandle(buffer);
  }
}

void ChunkBorrower::wake_writer() noexcept {
  if (owes_wake_.exchange(false, std::memory_order_relaxed)) QueueRoom(queue_.port()).wake();
}

/// Counts the case that a chunk waits, but the limit of held samples is reached.
void ChunkBorrower::count_held_too_many() noexcept {
  held_too_many_.fetch_add(1, std::memory_order_relaxed);
  statistics_->over_limit.fetch_add(1, std::memory_order_relaxed);
}

/// Checks the sample, and copies the checked values into the buffer, which is in the memory of this
/// process. The header in the chunk must not be read again, because a hostile writer can still change it.
/// `popped` is the number of chunks taken out of the queue so far.
bool ChunkBorrower::check(ChunkSlot& slot, std::uint64_t popped) noexcept {
  SampleBuffer& buffer = slot.buffer;
  buffer.data = static_cast<std::byte*>(slot.chunk->userPayload());
  const std::size_t size = slot.chunk->userPayloadSize();
  const bool in_place =
      reinterpret_cast<std::uintptr_t>(buffer.data) % 8 == 0 && session_->holds(buffer.data, size);
  const auto sample = in_place ? check_sample(buffer.data, size, type_, writer_) : std::nullopt;
  if (!sample) {
    statistics_->malformed.fetch_add(1, std::memory_order_relaxed);
    discarded_.fetch_add(1, std::memory_order_relaxed);
    return false;
  }
  buffer.capacity = sample->bytes;
  buffer.origin() = sample->origin;
  buffer.oldest_retained = retained_first_ && losses_.nothing_came_before() ? buffer.sequence : 0;
  const std::uint64_t lost = losses_.enter(buffer.sequence, popped, [this] { return depth(); });
  if (lost != 0) discarded_.fetch_add(lost, std::memory_order_relaxed);
  return true;
}

void ChunkBorrower::recycle(SampleBuffer& buffer) noexcept {
  before_chunk_leaves();
  queue_.give_back(ChunkSlot::of(buffer));
}

std::optional<std::uint64_t> ChunkBorrower::drop_oldest() noexcept {
  const std::optional<std::uint64_t> bytes = queue_.drop_oldest();
  if (!bytes) return bytes;
  losses_.dropped();
  discarded_.fetch_add(1, std::memory_order_relaxed);
  return bytes;
}

ShmReaderPort::ShmReaderPort(std::shared_ptr<Session> session, const core::ReaderSpec& spec,
                             const ShmOptions& options, std::shared_ptr<Statistics> statistics)
    : session_(std::move(session)), spec_(spec), options_(options), statistics_(std::move(statistics)) {}

ShmReaderPort::~ShmReaderPort() {
  for (const auto& writer : writers_) writer->close();
}

SampleHandle ShmReaderPort::take() noexcept {
  Writers drained;  // destroyed after the lock is released
  const core::Lock lock(mutex_);
  if (!departed_.empty()) {
    if (SampleHandle sample = take_what_was_left(drained)) return sample;
  }
  for (std::size_t i = 0; i < writers_.size(); ++i) {
    const std::size_t at = (next_writer_ + i) % writers_.size();
    if (SampleHandle sample = writers_[at]->take()) {
      next_writer_ = at + 1;
      return sample;
    }
  }
  return {};
}

SampleHandle ShmReaderPort::take_of(core::EndpointId writer) noexcept {
  const core::Lock lock(mutex_);
  const auto found = std::ranges::find_if(writers_, [&](const auto& w) { return w->writer() == writer; });
  return found == writers_.end() ? SampleHandle() : (*found)->take();
}

bool ShmReaderPort::some_wait() const noexcept {
  const auto has_some = [](const auto& writer) { return writer->some_wait(); };
  const core::Lock lock(mutex_);
  return std::ranges::any_of(writers_, has_some) || std::ranges::any_of(departed_, has_some);
}

void ShmReaderPort::notify_room() noexcept {
  for (;;) {
    std::shared_ptr<ChunkBorrower> due;
    {
      const core::Lock lock(mutex_);
      const auto found = std::ranges::find_if(writers_, [](const auto& w) { return w->owes_wake(); });
      if (found == writers_.end()) return;
      due = *found;
    }
    due->wake_writer();
  }
}

SampleHandle ShmReaderPort::take_what_was_left(Writers& drained) noexcept {
  SampleHandle sample;
  for (auto writer = departed_.begin(); writer != departed_.end() && !sample; ++writer)
    sample = (*writer)->take();
  drained = forget_drained();
  return sample;
}

void ShmReaderPort::drop_excess() noexcept {
  std::uint64_t left = 0, bytes = 0;
  for (const auto& writer : departed_) {
    left += writer->left();
    bytes += writer->bytes_left();
  }
  const auto are_too_many = [&] {
    return left > depth() || (spec_.depth_bytes != 0 && bytes > spec_.depth_bytes && left > 1);
  };
  for (const auto& writer : departed_) {
    while (are_too_many()) {
      const std::optional<std::uint64_t> dropped = writer->drop_oldest();
      if (!dropped) break;
      --left;
      bytes -= std::min(bytes, *dropped);
    }
  }
}

/// Removes the departed writers whose samples were all taken or dropped. Returns these writers.
ShmReaderPort::Writers ShmReaderPort::forget_drained() noexcept {
  Writers drained;
  std::erase_if(departed_, [&drained](const auto& writer) {
    if (!writer->drained()) return false;
    drained.push_back(writer);
    return true;
  });
  for (const auto& writer : drained) {
    discarded_before_ += writer->discarded();
    held_too_many_before_ += writer->held_too_many();
    lost_unnoticed_ += writer->lost_unnoticed();
  }
  return drained;
}

Result<void> ShmReaderPort::connect(const core::Source& source) {
  if (find(source.writer) != nullptr) return {};
  const QueueWishes wishes{.reader = spec_.id,
                           .late = source.history_first,
                           .awaited = source.reliable && source.waits,
                           .deepest = depth() == QueuePlaces::depth_max,
                           .bytes_max = spec_.depth_bytes};
  auto port = session_->create_subscriber(source.writer, depth(),
                                          {options_.port_wait, options_.port_deadline}, wishes);
  if (!port) return tl::unexpected(port.error());
  auto writer =
      ChunkBorrower::make(session_, **port, source.writer, *spec_.type, statistics_, max_held(), wishes);
  const core::Lock lock(mutex_);
  writers_.push_back(std::move(writer));
  return {};
}

bool ShmReaderPort::connected(core::EndpointId writer) const noexcept {
  const auto found = find(writer);
  return found != nullptr && found->connected();
}

core::HistoryProgress ShmReaderPort::history(core::EndpointId writer) const noexcept {
  const auto found = find(writer);
  const bool awaited = found != nullptr && found->awaits_retained();
  return awaited ? core::HistoryProgress::awaited : core::HistoryProgress::came;
}

std::uint64_t ShmReaderPort::arrivals(core::EndpointId writer) noexcept {
  const auto found = find(writer);
  return found == nullptr ? 0 : found->arrivals();
}

void ShmReaderPort::disconnect(core::EndpointId writer) noexcept {
  const auto gone = find(writer);
  if (gone == nullptr) return;
  gone->close();
  Writers drained;  // destroyed after the lock is released
  const core::Lock lock(mutex_);
  std::erase(writers_, gone);
  departed_.push_back(gone);
  drop_excess();
  drained = forget_drained();
}

core::ReaderPort::Counters ShmReaderPort::counters() const noexcept {
  const core::Lock lock(mutex_);
  Counters counters{discarded_before_, lost_unnoticed_};
  for (const auto& writer : writers_) counters.discarded += writer->discarded();
  for (const auto& writer : departed_) counters.discarded += writer->discarded();
  return counters;
}

std::uint64_t ShmReaderPort::held_too_many() const noexcept {
  const core::Lock lock(mutex_);
  std::uint64_t sum = held_too_many_before_;
  for (const auto& writer : writers_) sum += writer->held_too_many();
  for (const auto& writer : departed_) sum += writer->held_too_many();
  return sum;
}

std::shared_ptr<ChunkBorrower> ShmReaderPort::find(core::EndpointId writer) const noexcept {
  const core::Lock lock(mutex_);
  const auto found =
      std::ranges::find_if(writers_, [&](const auto& w) { return w->writer() == writer && w->open(); });
  return found == writers_.end() ? nullptr : *found;
}

}  // namespace sft::shm
