#include "shm_transport/host/session.h"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <tuple>

#include "core/platform/doorbell.h"
#include "core/platform/random_id.h"
#include "shm_transport/host/access.h"
#include "shm_transport/host/iceoryx_runtime.h"
#include "shm_transport/host/membership.h"
#include "shm_transport/host/port_lock.h"
#include "shm_transport/host/queue_places.h"

namespace sft::shm {

using iox::popo::BasePortData;
using iox::popo::PublisherPortData;
using iox::popo::SubscriberPortData;

namespace {

iox::capro::ServiceDescription service_of(core::EndpointId writer) {
  return {"sft", "w", iox::capro::IdString_t(iox::cxx::TruncateToCapacity, core::in_hex(writer))};
}

using QueueData = SubscriberPortData::ChunkQueueData_t;

bool delivers_to(const PublisherPortData& publisher, const QueueData& queue) {
  const auto& queues = publisher.m_chunkSenderData.m_queues;
  return std::any_of(queues.begin(), queues.end(),
                     [&queue](const auto& known) { return known.get() == &queue; });
}

}  // namespace

Session::Session(std::shared_ptr<IceoryxRuntime> runtime, HostMonitor monitor,
                 std::unique_ptr<RoudiChannel> channel)
    : runtime_(std::move(runtime)),
      monitor_(std::move(monitor)),
      channel_(std::move(channel)),
      token_(host_token(monitor_.file())) {}

Session::~Session() {
  if (!lost_) {
    channel_->say_goodbye();
    forget_segments();
  }
}

Result<std::shared_ptr<Session>> Session::open(std::shared_ptr<IceoryxRuntime> runtime, HostMonitor monitor,
                                               std::unique_ptr<RoudiChannel> channel,
                                               const Registration& registration) {
  std::shared_ptr<Session> session(new Session(std::move(runtime), std::move(monitor), std::move(channel)));
  if (auto mapped = session->map(registration); !mapped) return tl::unexpected(mapped.error());
  // If the daemon that wrote the token is still alive, no other daemon can have answered this process.
  if (!session->daemon_lives())
    return fail(Errc::unavailable, "sftd went away while this process registered");
  return session;
}

Result<void> Session::map(const Registration& registration) {
  const auto management_bytes = static_cast<std::size_t>(registration.management_bytes);
  auto added = add_segment(registration.management_id, iox::roudi::SHM_NAME, management_bytes, true);
  if (!added) return added;
  using SegmentManager = iox::mepoo::SegmentManager<>;
  const std::span<std::byte> management = segments_.front().mapping.bytes();
  if (registration.segment_manager_offset > management.size() ||
      management.size() - registration.segment_manager_offset < sizeof(SegmentManager) ||
      port_pool() == nullptr) {
    return fail(Errc::malformed,
                "the management segment of sftd is not as sftd announced it; is sftd of another version?");
  }
  return add_samples();
}

/// Tries to map the samples for writing, and then for reading only. Only the kernel knows the rights of
/// this process, because the groups that a service manager or a container gives to a process are in no
/// file.
Result<void> Session::add_samples() {
  const HostFile& file = monitor_.file();
  auto added = add_segment(file.segment_id, file.segment, file.segment_bytes, true);
  if (added || added.error().code != Errc::no_permission) return added;
  can_write_ = false;
  return add_segment(file.segment_id, file.segment, file.segment_bytes, false);
}

Result<void> Session::add_segment(std::uint64_t id, const std::string& name, std::size_t bytes,
                                  bool writable) {
  auto mapping = Mapping::open(name, bytes, writable, monitor_.user());
  if (!mapping) return tl::unexpected(mapping.error());
  if (!runtime_->announce_segment(id, mapping->bytes())) {
    return fail(Errc::address_in_use,
                "this process already uses iceoryx without SFT; a program that uses SFT's shared memory must "
                "not use iceoryx itself");
  }
  segments_.push_back({id, std::move(*mapping)});
  return {};
}

void Session::forget_segments() noexcept {
  for (const Segment& segment : segments_) runtime_->withdraw_segment(segment.id);
}

const iox::roudi::PortPoolData* Session::port_pool() const {
  const std::span<std::byte> management = segments_.front().mapping.bytes();
  const std::uint64_t offset = monitor_.file().port_pool_offset;
  if (offset == 0 || offset > management.size()) return nullptr;
  if (management.size() - offset < sizeof(iox::roudi::PortPoolData)) return nullptr;
  return reinterpret_cast<const iox::roudi::PortPoolData*>(management.data() + offset);
}

BasePortData* Session::port_at(const PortLocation& location, std::size_t bytes) const {
  const Segment& management = segments_.front();
  const std::size_t size = management.mapping.bytes().size();
  if (location.segment_id != management.id || location.offset > size || size - location.offset < bytes)
    return nullptr;
  return reinterpret_cast<BasePortData*>(management.mapping.bytes().data() + location.offset);
}

RoudiChannel::TakePort Session::take_port() const {
  return [this](const PortLocation& location, const std::string& label) {
    BasePortData* port = port_at(location, sizeof(BasePortData));
    if (port == nullptr) return false;
    if (port->m_nodeName == iox::NodeName_t(iox::cxx::TruncateToCapacity, label)) return true;
    port->m_toBeDestroyed.store(true, std::memory_order_release);
    return false;
  };
}

template <class PortData>
Result<PortData*> Session::answered_port(const Result<PortLocation>& location) const {
  if (!location) return tl::unexpected(location.error());
  auto* port = static_cast<PortData*>(port_at(*location, sizeof(PortData)));
  if (port == nullptr) return fail(Errc::malformed, "sftd answered with a port outside its memory");
  return port;
}

Result<PublisherPortData*> Session::create_publisher(core::EndpointId writer,
                                                     const RoudiChannel::Timeouts& timeouts) {
  if (!can_write_) {
    return fail(Errc::no_permission,
                "this program may read samples in shared memory but not write them; " +
                    how_to_join(Membership::of_this_process(segments_.front().mapping.group())));
  }
  iox::popo::PublisherOptions options;
  options.historyCapacity = 0;
  options.subscriberTooSlowPolicy = iox::popo::ConsumerTooSlowPolicy::DISCARD_OLDEST_DATA;
  return answered_port<PublisherPortData>(
      channel_->create_publisher(service_of(writer), options, take_port(), timeouts));
}

Result<SubscriberPortData*> Session::create_subscriber(core::EndpointId writer, std::uint32_t depth,
                                                       const RoudiChannel::Timeouts& timeouts,
                                                       const QueueWishes& wishes) {
  iox::popo::SubscriberOptions options;
  options.queueCapacity = QueuePlaces::capacity_for(depth);
  options.historyRequest = 0;
  options.subscribeOnCreate = depth != 0;
  options.queueFullPolicy = iox::popo::QueueFullPolicy::DISCARD_OLDEST_DATA;
  return answered_port<SubscriberPortData>(
      channel_->create_subscriber(service_of(writer), options, take_port(), timeouts, to_text(wishes)));
}

const SubscriberPortData* Session::port_of(const QueueData& queue) const noexcept {
  auto& table = const_cast<iox::roudi::PortPoolData*>(port_pool())->m_subscriberPortMembers;
  for (const SubscriberPortData* port : table.content()) {
    if (static_cast<const QueueData*>(&port->m_chunkReceiverData) == &queue) return port;
  }
  return nullptr;
}

void Session::admit_writers(std::uint64_t doorbell_page) const {
  const std::string path = core::DoorbellPage::path_of(doorbell_page);
  const auto page = core::open_trusted_file(path, O_RDWR);
  if (!page) return;  // a writer that cannot open the page reports the reason
  const gid_t writers = segments_.front().mapping.group();
  if (fchown(page->get(), static_cast<uid_t>(-1), writers) == 0) return;
  // This process is not a member of the writers' group, so it cannot give the page of doorbells to that
  // group. It gives the page to the group of readers instead, and adds the right of the writers' group to
  // open the page. The group of the page shows writers that the daemon serves this process.
  if (const auto readers = monitor_.file().readers)
    std::ignore = fchown(page->get(), static_cast<uid_t>(-1), *readers);
  std::ignore = grant_to_group(path, writers);
}

core::TrustedAccounts Session::reader_accounts() const {
  core::TrustedAccounts accounts{.users = {monitor_.user()}, .groups = {segments_.front().mapping.group()}};
  if (const auto readers = monitor_.file().readers) accounts.groups.push_back(*readers);
  return accounts;
}

ChunkPools& Session::pools(const iox::mepoo::MemoryManager& pools) {
  const core::Lock lock(mutex_);
  if (pools_ == nullptr) {
    pools_ = std::make_unique<ChunkPools>(pools, segments_.back().mapping.bytes(),
                                          segments_.front().mapping.bytes(), segments_.back().mapping.file());
  }
  return *pools_;
}

void Session::prepare_chunks() noexcept {
  ChunkPools* pools = nullptr;
  {
    const core::Lock lock(mutex_);
    pools = pools_.get();
  }
  if (pools != nullptr) pools->prepare();
}

/// Searches the daemon's table of ports, because iceoryx does not report to a subscriber whether it is
/// connected: in its N:M build a port is SUBSCRIBED as soon as it has requested that. If the table changes
/// during the search, the result is out of date, or null.
const PublisherPortData* Session::feeder_of(const SubscriberPortData& port) const noexcept {
  auto& table = const_cast<iox::roudi::PortPoolData*>(port_pool())->m_publisherPortMembers;
  const auto publishers = table.content();
  const auto feeder = std::find_if(publishers.begin(), publishers.end(),
                                   [&port](const auto* publisher) { return feeds(*publisher, port); });
  return feeder == publishers.end() ? nullptr : *feeder;
}

bool Session::feeds(const PublisherPortData& feeder, const SubscriberPortData& port) noexcept {
  return feeder.m_serviceDescription == port.m_serviceDescription &&
         delivers_to(feeder, port.m_chunkReceiverData);
}

void Session::retire(SubscriberPortData* port) {
  const core::Lock lock(mutex_);
  if (!lost_) retired_.push_back(port);
}

void Session::collect() {
  channel_->give_back_untaken(take_port());
  const core::Lock lock(mutex_);
  if (lost_) return;
  std::erase_if(retired_, [this](SubscriberPortData* port) {
    const bool unsubscribed = port->m_subscriptionState.load() == iox::SubscribeState::NOT_SUBSCRIBED;
    // A writer that was killed while it delivered leaves the queue locked until sftd has opened the lock.
    // sftd must not destroy the port before that.
    if (!unsubscribed || feeder_of(*port) != nullptr || is_closed(port->m_chunkReceiverData)) return false;
    port->m_toBeDestroyed.store(true, std::memory_order_release);
    return true;
  });
}

bool Session::holds(const void* data, std::size_t size) const {
  return std::any_of(segments_.begin() + 1, segments_.end(),
                     [&](const Segment& segment) { return segment.mapping.contains(data, size); });
}

void Session::enlist(const std::shared_ptr<SessionMember>& member) {
  {
    const core::Lock lock(mutex_);
    std::erase_if(members_, [](const auto& other) { return other.expired(); });
    if (!lost_) {
      members_.push_back(member);
      return;
    }
  }
  member->lose(SessionMember::Loss::before);
}

void Session::lose() noexcept {
  std::vector<std::weak_ptr<SessionMember>> members;
  {
    const core::Lock lock(mutex_);
    if (std::exchange(lost_, true)) return;
    members.swap(members_);
  }
  for (const bool senders : {true, false}) {
    for (const auto& member : members) {
      if (const auto held = member.lock(); held != nullptr && held->sends() == senders)
        held->lose(SessionMember::Loss::now);
    }
  }
  forget_segments();
}

}  // namespace sft::shm
