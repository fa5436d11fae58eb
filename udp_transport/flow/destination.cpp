#include "udp_transport/flow/destination.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <memory>
#include <optional>
#include <random>
#include <utility>
#include <vector>

#include "udp_transport/io/interfaces.h"
#include "udp_transport/wire/fragmenter.h"

namespace sft::udp {

namespace {
std::uint64_t random_secret() {
  std::random_device random;
  return std::uint64_t{random()} << 32 | random();
}

FlowLimits flow_limits(const DestinationLimits& limits) {
  FlowLimits flow = limits.flow;
  flow.asks = limits.report_port != 0;
  return flow;
}
}  // namespace

Destination::Destination(const SocketAddress& address, const DestinationLimits& limits, std::uint32_t flow,
                         Connect connect, std::uint32_t channels, std::shared_ptr<UnprovenBudget> host)
    : limits_(limits),
      flow_(flow),
      channels_(channels),
      connect_(std::move(connect)),
      address_(address),
      path_(path_to(address)),
      datagram_bytes_(path_.datagram_bytes()),
      connection_(connect_(address)),
      window_(flow, flow_limits(limits), random_secret(), std::move(host)),
      answers_(limits.report_port == 0) {}

std::size_t Destination::ask_kernel(const SocketAddress& address) const noexcept {
  return std::min<std::size_t>(datagram_bytes_to(address),
                               std::max(limits_.datagram_bytes, datagram_bytes_min));
}

PathMtu Destination::path_to(const SocketAddress& address) const noexcept {
  const std::size_t kernel_says = ask_kernel(address);
  return {headers_before_datagram(address.ip),
          std::min(datagram_bytes_of_every_path(address.ip), kernel_says), kernel_says};
}

void Destination::publish_length() noexcept {
  datagram_bytes_.store(path_.datagram_bytes(), std::memory_order_relaxed);
  length_in_doubt_.store(path_.in_doubt(), std::memory_order_relaxed);
}

std::size_t Destination::datagrams_per_call() const {
  return one_at_a_time_.load(std::memory_order_relaxed) ? 1 : batch_datagrams_max;
}

void Destination::set_receive_buffer(std::uint32_t bytes) {
  receive_buffer_bytes_.store(bytes, std::memory_order_relaxed);
  const std::scoped_lock lock(window_mutex_);
  window_.announce(bytes);
}

SocketAddress Destination::address() const {
  const std::scoped_lock lock(mutex_);
  return address_;
}

void Destination::move_to(const SocketAddress& address, std::shared_ptr<UnprovenBudget> host) noexcept {
  {
    const std::scoped_lock lock(mutex_);
    if (address == std::exchange(address_, address)) return;
    also_at_.clear();
  }
  {
    const std::scoped_lock lock(window_mutex_);
    window_.move(random_secret(), std::move(host));
    answers_.store(limits_.report_port == 0, std::memory_order_relaxed);
  }
  connection_->redirect(address);
  one_at_a_time_.store(false, std::memory_order_relaxed);
  if (Connection* const bulk = bulk_in_use_.load(std::memory_order_acquire)) bulk->redirect(address);
  const PathMtu path = path_to(address);
  const std::scoped_lock lock(mutex_);
  path_ = path;
  publish_length();
  moves_.fetch_add(1, std::memory_order_relaxed);
}

void Destination::note(SendOutcome outcome) noexcept {
  if (outcome == SendOutcome::no_segments) one_at_a_time_.store(true, std::memory_order_relaxed);
  if (outcome == SendOutcome::too_long) learn_from_kernel();
  if (outcome == SendOutcome::too_long || outcome == SendOutcome::failed) reconnect();
}

void Destination::reconnect() noexcept {
  connection_->reconnect();
  if (Connection* const bulk = bulk_in_use_.load(std::memory_order_acquire)) bulk->reconnect();
}

/// The destination may have moved before others know of that connection.
Connection& Destination::bulk() {
  if (bulk_ == nullptr) {
    const SocketAddress to = address();
    bulk_ = connect_(to);
    bulk_->carry_bulk();
    bulk_in_use_.store(bulk_.get(), std::memory_order_release);
    if (const SocketAddress now = address(); now != to) bulk_->redirect(now);
  }
  return *bulk_;
}

Connection& Destination::connection_after(std::uint64_t position) {
  if (position == 0) return *connection_;
  const std::scoped_lock lock(window_mutex_);
  return window_.passed(position) ? *connection_ : last_in_line();
}

std::size_t Destination::room(Size size, Time now) {
  const std::scoped_lock lock(window_mutex_);
  const std::size_t room = window_.room(size, now);
  if (room == 0) note_answers(now);
  return room;
}

/// REQUIRES: the mutex of the window is held.
void Destination::note_answers(Time now) { answers_.store(window_.answers(now), std::memory_order_relaxed); }

bool Destination::takes_control(Time now) {
  const std::scoped_lock lock(window_mutex_);
  const bool takes = window_.takes_control(now);
  control_withheld_ = control_withheld_ || !takes;
  return takes;
}

bool Destination::is_mute(Time now) {
  const std::scoped_lock lock(window_mutex_);
  return window_.is_mute(now);
}

std::size_t Destination::batch_bytes() {
  const std::scoped_lock lock(window_mutex_);
  return window_.batch_bytes();
}

void Destination::sent(const Connection& by, std::size_t bytes, std::size_t datagrams, Time now) {
  std::optional<FlowMark> due;
  {
    const std::scoped_lock lock(window_mutex_);
    window_.sent(bytes, datagrams, now, &by != &last_in_line());
    due = window_.mark(now);
  }
  if (due) send(*due, now);
}

void Destination::mark(Time now) {
  std::optional<FlowMark> due;
  {
    const std::scoped_lock lock(window_mutex_);
    window_.await_room();
    due = window_.mark(now);
  }
  if (due) send(*due, now);
}

void Destination::refused(Time now) {
  const std::scoped_lock lock(window_mutex_);
  window_.refused(now);
  note_answers(now);
}

/// One that does not leave is made up for by a later one.
void Destination::send(FlowMark mark, Time now) {
  mark.port = limits_.report_port;
  std::array<std::byte, mark_bytes> encoded;
  encode(mark, encoded.data());
  const iovec part{encoded.data(), encoded.size()};
  const OutgoingBatch batch{{&part, 1}, 0};
  if (last_in_line().try_send({&batch, 1}).refused) refused(now);
}

Destination::Heard Destination::hear(const FlowReport& report, const core::IpAddress& from, Time now) {
  Heard heard;
  {
    const std::scoped_lock lock(window_mutex_);
    heard.believed = window_.answers_a_mark(report);
    if (!heard.believed) return heard;
    heard.goes_on = window_.hear(report, now);
    note_answers(now);
    if (std::exchange(control_withheld_, false)) moves_.fetch_add(1, std::memory_order_relaxed);
  }
  if (!is_at(from)) learn(from);
  return heard;
}

void Destination::lives(Time now) {
  const std::scoped_lock lock(window_mutex_);
  window_.lives(now);
}

bool Destination::is_at(const core::IpAddress& ip) const {
  const std::scoped_lock lock(mutex_);
  return ip == address_.ip || std::ranges::find(also_at_, ip) != also_at_.end();
}

/// Learns another address of the destination: its host has several, or somebody on the way translates
/// addresses.
void Destination::learn(const core::IpAddress& from) {
  const std::scoped_lock lock(mutex_);
  if (also_at_.size() == also_at_max) also_at_.pop_front();
  also_at_.push_back(from);
}

Destination::Time Destination::next_ready(Time now) {
  const std::scoped_lock lock(window_mutex_);
  return window_.next_ready(now);
}

Destination::Time::duration Destination::round_trip() {
  const std::scoped_lock lock(window_mutex_);
  return window_.round_trip();
}

std::uint64_t Destination::position() {
  const std::scoped_lock lock(window_mutex_);
  return window_.position();
}

void Destination::learn_from_kernel() noexcept {
  const SocketAddress asked = address();
  const std::size_t says = ask_kernel(asked);
  const std::scoped_lock lock(mutex_);
  if (asked == address_) path_.kernel_says(says);
  publish_length();
}

void Destination::long_ones_were_lost(PathMtu::Time now) noexcept {
  const std::scoped_lock lock(mutex_);
  path_.lost(now);
  publish_length();
}

void Destination::long_ones_arrived(PathMtu::Time now) noexcept {
  const std::scoped_lock lock(mutex_);
  path_.arrived(now);
  publish_length();
}

void Destination::look_after(PathMtu::Time now, bool anew) noexcept {
  if (anew) reconnect();
  if (anew || now - kernel_asked_at_ >= kernel_is_asked_every) {
    kernel_asked_at_ = now;
    learn_from_kernel();
  }
  const std::scoped_lock lock(mutex_);
  path_.look_after(now);
  publish_length();
}

DestinationDirectory::DestinationDirectory(const DestinationLimits& limits, Connect connect)
    : limits_(limits), connect_(std::move(connect)), channel_key_{random_secret(), random_secret()} {}

DestinationDirectory::Key DestinationDirectory::key_of(const core::UdpAddress& address) {
  return {address.node, {address.node == 0 ? address.ip : core::IpAddress{}, address.port}};
}

/// The same whenever that socket is known again: its process takes channels with greater numbers for newer
/// ones.
std::uint32_t DestinationDirectory::first_channel(const Key& key) const {
  std::array<std::uint64_t, 5> words{key.first, 0, 0, key.second.ip.scope, key.second.port};
  std::memcpy(&words[1], key.second.ip.bytes.data(), key.second.ip.bytes.size());
  return static_cast<std::uint32_t>(keyed_hash(channel_key_, words));
}

/// REQUIRES: the mutex is held. A caller that does not know whose an address is may find a destination that
/// is there at present.
std::shared_ptr<Destination> DestinationDirectory::known(const core::UdpAddress& address) {
  std::erase_if(known_, [](const auto& entry) { return entry.second.expired(); });
  if (const auto found = known_.find(key_of(address)); found != known_.end()) return found->second.lock();
  if (address.node != 0) return nullptr;
  for (const auto& [key, entry] : known_) {
    std::shared_ptr<Destination> destination = entry.lock();
    if (destination != nullptr && destination->address() == SocketAddress{address.ip, address.port})
      return destination;
  }
  return nullptr;
}

std::shared_ptr<Destination> DestinationDirectory::find(const core::UdpAddress& address) {
  const SocketAddress to{address.ip, address.port};
  std::shared_ptr<Destination> destination;
  std::shared_ptr<UnprovenBudget> host;
  std::uint32_t flow = 0;
  {
    const std::scoped_lock lock(mutex_);
    host = hosts_.of(to.ip, std::chrono::steady_clock::now());
    destination = known(address);
    flow = destination == nullptr ? unused_flow() : 0;
  }
  if (destination == nullptr) {
    auto fresh =
        std::make_shared<Destination>(to, limits_, flow, connect_, first_channel(key_of(address)), host);
    const std::scoped_lock lock(mutex_);
    destination = known(address);
    if (destination == nullptr) known_[key_of(address)] = destination = std::move(fresh);
  }
  if (address.node != 0) destination->move_to(to, std::move(host));
  if (address.receive_buffer_bytes != 0) destination->set_receive_buffer(address.receive_buffer_bytes);
  return destination;
}

/// Nobody else can guess it. With the mutex held.
std::uint32_t DestinationDirectory::unused_flow() {
  std::random_device random;
  for (;;) {
    const std::uint32_t flow = random();
    const auto has_it = [flow](const auto& entry) {
      const std::shared_ptr<Destination> destination = entry.second.lock();
      return destination != nullptr && destination->flow() == flow;
    };
    if (std::ranges::none_of(known_, has_it)) return flow;
  }
}

std::shared_ptr<Destination> DestinationDirectory::of_flow(std::uint32_t flow) {
  const std::scoped_lock lock(mutex_);
  for (const auto& [address, known] : known_) {
    if (auto destination = known.lock(); destination != nullptr && destination->flow() == flow)
      return destination;
  }
  return nullptr;
}

void DestinationDirectory::look_after(PathMtu::Time now, bool anew) {
  std::vector<std::shared_ptr<Destination>> all;
  {
    const std::scoped_lock lock(mutex_);
    for (const auto& [key, entry] : known_) all.push_back(entry.lock());
  }
  for (const std::shared_ptr<Destination>& destination : all) {
    if (destination != nullptr) destination->look_after(now, anew);
  }
}

}  // namespace sft::udp
