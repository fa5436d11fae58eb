#include "shm_transport/ports/writer_port.h"

#include <algorithm>
#include <cassert>
#include <new>
#include <thread>
#include <utility>

#include "core/sync/spin.h"
#include "shm_transport/host/chunk_hand.h"
#include "shm_transport/host/queue_room.h"

namespace sft::shm {

using core::SampleBuffer;
using core::SampleHandle;
using core::SendStatus;
using iox::mepoo::ChunkHeader;
using iox::mepoo::SharedChunk;
using iox::mepoo::ShmSafeUnmanagedChunk;

namespace {

// The limit of a sample's size, far greater than the chunks of any pool. It keeps sums of sizes below 2^32.
constexpr std::size_t largest_sample_bytes = 1'000'000'000;

// The maximum number of pauses and the length of each pause in which a send waits for the lock of its port
// while the daemon holds that lock.
constexpr int lock_attempts = 20;
constexpr std::chrono::microseconds lock_pause{50};

// A writer that waits for room first spins for `room_spin`. Then it sleeps, and checks after
// `room_sleep_longest` at most whether the reader still exists, because a reader that was killed does not
// wake it.
constexpr std::chrono::microseconds room_spin{20};
constexpr std::chrono::milliseconds room_sleep_longest{10};

}  // namespace

std::shared_ptr<ShmWriterPort> ShmWriterPort::make(std::shared_ptr<Session> session,
                                                   iox::popo::PublisherPortData& publisher,
                                                   iox::popo::SubscriberPortData& keeper,
                                                   const core::WriterSpec& spec, std::uint32_t held_limit,
                                                   std::shared_ptr<DoorbellPages> pages,
                                                   std::shared_ptr<Statistics> statistics) {
  std::shared_ptr<ShmWriterPort> port(new ShmWriterPort(session, publisher, keeper, spec, held_limit,
                                                        std::move(pages), std::move(statistics)));
  session->enlist(port);
  return port;
}

ShmWriterPort::ShmWriterPort(std::shared_ptr<Session> session, iox::popo::PublisherPortData& publisher,
                             iox::popo::SubscriberPortData& keeper, const core::WriterSpec& spec,
                             std::uint32_t held_limit, std::shared_ptr<DoorbellPages> pages,
                             std::shared_ptr<Statistics> statistics)
    : largest_bytes_(session->pools(*publisher.m_chunkSenderData.m_memoryMgr).largest_bytes()),
      retains_(spec.retains),
      max_blocking_(spec.max_blocking),
      pages_(std::move(pages)),
      statistics_(std::move(statistics)),
      reader_accounts_(session->reader_accounts()),
      session_(std::move(session)),
      publisher_(publisher),
      port_(&publisher),
      keeper_(keeper),
      pools_(session_->pools(*publisher.m_chunkSenderData.m_memoryMgr)),
      slots_(held_limit, spec.type->full()) {}

/// Runs only after all samples were given back. Marking the ports only writes to mapped memory, so it is
/// allowed even if the daemon is gone.
ShmWriterPort::~ShmWriterPort() {
  if (session_ == nullptr) return;
  port_.destroy();
  keeper_.m_toBeDestroyed.store(true, std::memory_order_release);
}

SampleHandle ShmWriterPort::lend(std::size_t bytes) noexcept {
  if (bytes < sizeof(detail::SampleHeader) || bytes > largest_sample_bytes) return {};
  ChunkSlot* slot = nullptr;
  ChunkPools* pools = nullptr;  // the pools of the session, which stays alive as long as the slot is in use
  {
    const core::Lock lock(mutex_);
    pools = &pools_;
    if (lost_ || slots_.empty()) return {};
    const ChunkInHand hand(publisher_);
    ChunkHeader* chunk = allocate(bytes);
    if (chunk == nullptr) return {};
    slot = slots_.take();
    hold(*slot, *chunk);
  }
  after_chunk_came();
  SampleBuffer& buffer = slot->buffer;
  if (!pools->set_aside(*slot->chunk, bytes)) {
    recycle(buffer);
    return {};
  }
  buffer.data = static_cast<std::byte*>(slot->chunk->userPayload());
  // The size in the chunk's header is not used, because every client can overwrite it.
  buffer.capacity = bytes;
  buffer.owner = shared_from_this();
  new (buffer.data) detail::SampleHeader{};
  return SampleHandle(buffer);
}

ChunkHeader* ShmWriterPort::allocate(std::size_t bytes) noexcept {
  // If no other process holds the last chunk of a publisher, iceoryx lends that chunk again, even if all
  // pools are empty.
  auto& last = publisher_.m_chunkSenderData.m_lastChunkUnmanaged;
  if (last.isNotLogicalNullptrAndHasNoOtherOwners() &&
      last.getChunkHeader()->chunkSize() >= payload_for(bytes) + chunk_header_size) {
    auto again = port_.tryAllocateChunk(static_cast<std::uint32_t>(payload_for(bytes)),
                                        alignof(detail::SampleHeader), 0, 1);
    return again.has_error() ? nullptr : again.value();
  }
  while (const auto choice = pools_.choose(bytes)) {
    auto chunk = port_.tryAllocateChunk(choice->payload_bytes, alignof(detail::SampleHeader), 0, 1);
    if (!chunk.has_error()) {
      pools_.note_taken(*choice, bytes);
      return chunk.value();
    }
    if (chunk.get_error() != iox::popo::AllocationError::RUNNING_OUT_OF_CHUNKS) return nullptr;
    pools_.note_empty(*choice);
  }
  return nullptr;
}

/// Moves the chunk from iceoryx's own list of loans to the keeper's list of held chunks.
void ShmWriterPort::hold(ChunkSlot& slot, ChunkHeader& chunk) noexcept {
  SharedChunk lent;
  publisher_.m_chunkSenderData.m_chunksInUse.remove(&chunk, lent);
  ShmSafeUnmanagedChunk name(std::move(lent));
  slot.name = name;
  keeper_.m_chunkReceiverData.m_chunksInUse.insert(name.releaseToSharedChunk());
  slot.chunk = &chunk;
  slot.sent = false;
}

/// Delivers a lent sample to all readers that are served and want it, or to no reader if `to_readers` is
/// false. The daemon holds the lock of the port for microseconds, unless it was stopped or killed meanwhile.
ShmWriterPort::Commit ShmWriterPort::commit_at_once(ChunkSlot& slot, bool to_readers,
                                                    bool may_wait) noexcept {
  const core::Lock lock(mutex_);
  if (lost_) return Commit::lost;
  bool full = false;
  if (to_readers) {
    // The lock is recursive, and sendChunk() takes it, too. If this thread already holds the lock,
    // sendChunk() cannot block on it. Otherwise sendChunk() could block, if the daemon was stopped while it
    // held the lock.
    auto& port = publisher_.m_chunkSenderData;
    if (!port.tryLock()) return Commit::busy;
    attached_.look(port.m_queues, *session_);
    full = max_blocking_.count() > 0 && attached_.without_room(slot.buffer.capacity) != nullptr;
    const bool waits = full && may_wait;
    if (!waits) deliver(slot);
    port.unlock();
    if (waits) return Commit::full;
  }
  slot.sent = true;
  return full ? Commit::displaced : Commit::done;
}

void ShmWriterPort::deliver(ChunkSlot& slot) noexcept {
  auto& port = publisher_.m_chunkSenderData;
  const ChunkInHand hand(publisher_);
  if (attached_.all_want_all()) {
    // The chunk is put back into iceoryx's own list of loans, because only a chunk in this list can be
    // sent.
    port.m_chunksInUse.insert(slot.name.cloneToSharedChunk());
    before_chunk_leaves();
    attached_.make_room(slot.buffer.capacity);
    port_.sendChunk(slot.chunk);
    return;
  }
  if (attached_.has_waiting()) attached_.hold_back();
  for (const AttachedQueues::Listener& listener : attached_.listeners()) {
    if (listener.wants_sample())
      attached_.deliver(port, listener, slot.name.cloneToSharedChunk(), slot.buffer.capacity);
  }
}

std::optional<ShmWriterPort::FullQueue> ShmWriterPort::full_queue(std::uint64_t bytes) noexcept {
  const core::Lock lock(mutex_);
  auto& port = publisher_.m_chunkSenderData;
  if (lost_ || !port.tryLock()) return std::nullopt;
  attached_.look(port.m_queues, *session_);
  const AttachedQueues::Listener* full = attached_.without_room(bytes);
  port.unlock();
  if (full == nullptr) return std::nullopt;
  return FullQueue{full->places, full->bytes.beside(bytes), session_};
}

/// Sleeps until the reader without room has taken a sample, but at most until `until`. May return earlier.
/// Waits without a lock. If the reader is removed meanwhile, the memory of its port stays mapped, and only
/// words in that memory are read and written.
void ShmWriterPort::await_room(const ChunkSlot& slot, Clock::time_point until) noexcept {
  std::optional<FullQueue> full = full_queue(slot.buffer.capacity);
  if (!full) return;
  const auto has_room = [&] { return full->places.has_room(full->beside); };
  if (core::spin(std::min(until, Clock::now() + room_spin), has_room)) return;
  QueueRoom room(full->places.port());
  room.begin_waiting();
  const Clock::duration left = until - Clock::now();
  if (!has_room() && left.count() > 0)
    room.sleep(std::min<std::chrono::nanoseconds>(left, room_sleep_longest));
  room.end_waiting();
}

std::optional<std::uint64_t> ShmWriterPort::held_back(core::EndpointId reader) noexcept {
  const core::Lock lock(mutex_);
  auto& port = publisher_.m_chunkSenderData;
  if (lost_ || !retains_ || !port.tryLock()) return std::nullopt;
  attached_.look(port.m_queues, *session_);
  port.unlock();
  if (attached_.waiting(reader) == nullptr) return std::nullopt;
  return attached_.held_back();
}

bool ShmWriterPort::begin(core::EndpointId reader, const std::vector<SampleHandle>& retained,
                          std::uint64_t held_back) noexcept {
  const core::Lock lock(mutex_);
  auto& port = publisher_.m_chunkSenderData;
  if (lost_ || held_back != attached_.held_back() || !port.tryLock()) return false;
  attached_.look(port.m_queues, *session_);
  if (const AttachedQueues::Listener* listener = attached_.waiting(reader)) {
    const ChunkInHand hand(publisher_);
    for (const SampleHandle& sample : retained) {
      ChunkSlot& slot = ChunkSlot::of(*sample);
      attached_.deliver(port, *listener, slot.name.cloneToSharedChunk(), sample->capacity);
    }
    attached_.begun(reader);
  }
  port.unlock();
  return true;
}

void ShmWriterPort::recycle(SampleBuffer& buffer) noexcept {
  before_chunk_leaves();
  ChunkSlot& slot = ChunkSlot::of(buffer);
  // `gone` may be the last reference to the session. The destructor of the session unmaps memory, so it
  // must run after the lock is released.
  std::shared_ptr<Session> gone;
  const core::Lock lock(mutex_);
  if (!lost_) {
    const ChunkInHand hand(publisher_);
    SharedChunk held;  // its destructor gives the chunk back
    keeper_.m_chunkReceiverData.m_chunksInUse.remove(slot.chunk, held);
  }
  slots_.give_back(slot);
  gone = let_go();
}

void ShmWriterPort::lose(Loss) noexcept {
  std::shared_ptr<Session> gone;
  const core::Lock lock(mutex_);
  lost_ = true;
  gone = let_go();
}

/// Returns the session if this writer does not need the session's memory any more.
std::shared_ptr<Session> ShmWriterPort::let_go() noexcept {
  return lost_ && slots_.all_back() ? std::move(session_) : nullptr;
}

bool ShmWriterPort::can_send(const SampleBuffer& sample) const noexcept {
  // The flag needs no lock: the same thread calls this function and send(), which sets the flag.
  return sample.owner.get() == this && !static_cast<const ChunkSlot*>(sample.owner_data)->sent;
}

SampleHandle ShmWriterPort::loan(std::size_t bytes) noexcept {
  SampleHandle handle = lend(bytes);
  if (!handle) statistics_->over_limit.fetch_add(1, std::memory_order_relaxed);
  return handle;
}

SendStatus ShmWriterPort::send(const SampleHandle& sample) noexcept {
  assert(can_send(*sample) && sample->mask.is_full());
  if (!can_send(*sample)) return drop();
  const Doorbells* bells = doorbells_.load();
  const bool wanted = bells != nullptr && bells->wanted();
  ChunkSlot& slot = ChunkSlot::of(*sample);
  timeout_ = std::min(max_blocking_, timeout_max_);
  auto committed = commit(slot, wanted, timeout_.count() > 0);
  if (committed == Commit::full) [[unlikely]]
    committed = commit_once_there_is_room(slot);
  if (committed == Commit::lost) return SendStatus::lost_port;
  if (committed == Commit::busy) return drop();
  if (wanted) ring_for_sample();
  return committed == Commit::displaced ? SendStatus::displaced : SendStatus::sent;
}

/// Rings the doorbells of the list that send() has loaded. If set_routes() has made a new list since then,
/// also rings the doorbells of the new list: the readers may have changed their conditions, and may have
/// received the sample by their new conditions. set_routes() ensures that one of the two lists has the gate
/// that let the sample into a queue. A reader that is woken twice finds no sample the second time.
void ShmWriterPort::ring_for_sample() noexcept {
  const Doorbells* before = doorbells_.loaded().get();
  ring(doorbells_.loaded(), pages_->waker());
  const Doorbells* now = doorbells_.load();
  if (now != before && now != nullptr) ring(doorbells_.loaded(), pages_->waker());
}

ShmWriterPort::Commit ShmWriterPort::commit(ChunkSlot& slot, bool to_readers, bool may_wait) noexcept {
  auto committed = commit_at_once(slot, to_readers, may_wait);
  for (int i = 0; i < lock_attempts && committed == Commit::busy; ++i) {
    std::this_thread::sleep_for(lock_pause);
    committed = commit_at_once(slot, to_readers, may_wait);
  }
  return committed;
}

/// Waits until all readers for which this writer waits have room in their queues. If the timeout ends
/// first, the readers without room lose their oldest sample.
ShmWriterPort::Commit ShmWriterPort::commit_once_there_is_room(ChunkSlot& slot) noexcept {
  const Clock::time_point until = Clock::now() + timeout_;
  auto committed = Commit::full;
  while (committed == Commit::full) {
    await_room(slot, until);
    committed = commit(slot, true, Clock::now() < until);
  }
  timeout_ = std::max<std::chrono::nanoseconds>(until - Clock::now(), {});
  return committed;
}

SendStatus ShmWriterPort::drop() noexcept {
  statistics_->over_limit.fetch_add(1, std::memory_order_relaxed);
  return SendStatus::dropped;
}

bool ShmWriterPort::begin_with(const core::Route& to, const std::vector<SampleHandle>& retained,
                               std::uint64_t held_back) {
  if (!begin(to.reader, retained, held_back)) return false;
  core::Route whatever_its_rate = to;
  whatever_its_rate.gate = nullptr;
  const auto bell = pages_->doorbells_of({whatever_its_rate}, reader_accounts_);
  if (bell->announce() != 0) bell->wake();
  return true;
}

std::string ShmWriterPort::why_unreachable(const core::Route& to) {
  auto page = pages_->page_of(to, reader_accounts_);
  if (!page) return "it cannot be woken in shared memory: " + page.error().message;
  reached_.push_back(std::move(*page));
  return {};
}

/// Ensures that each reader that may get a sample is woken. The doorbell of a reader is in the list before
/// the reader is served, and until the reader is not served any more. While gates change, the list has the
/// doorbells with the former gates and with the new gates.
void ShmWriterPort::set_routes(std::vector<core::Route> routes) {
  std::set<core::EndpointId> owed_nothing, awaited;
  AttachedQueues::Served served;
  for (const core::Route& route : routes) {
    served[route.reader] = route.has_conditions() ? route.gate : nullptr;
    if (route.history == 0) owed_nothing.insert(route.reader);
    if (route.reliable) awaited.insert(route.reader);
  }
  {
    const core::Lock lock(mutex_);
    attached_.wait_for(std::move(awaited));
  }
  const auto leaves = [&served](const core::Route& route) { return !served.contains(route.reader); };
  const bool ring_for_both = std::ranges::any_of(routes, &core::Route::has_conditions) ||
                             std::ranges::any_of(routes_, &core::Route::has_conditions) ||
                             std::ranges::any_of(routes_, leaves);
  if (ring_for_both) routes_.insert(routes_.end(), routes.begin(), routes.end());
  const auto ring_for = [this](const std::vector<core::Route>& readers) {
    doorbells_.replace(readers.empty() ? nullptr : pages_->doorbells_of(readers, reader_accounts_));
  };
  ring_for(ring_for_both ? routes_ : routes);
  {
    const core::Lock lock(mutex_);
    attached_.serve(std::move(served));
    attached_.owe_nothing(std::move(owed_nothing));
  }
  if (ring_for_both) ring_for(routes);
  routes_ = std::move(routes);
  reached_.clear();
}

}  // namespace sft::shm
