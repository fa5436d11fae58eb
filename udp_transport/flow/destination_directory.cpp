#include "udp_transport/flow/destination_directory.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cstring>

#include "core/platform/random_id.h"

namespace sft::udp {

DestinationDirectory::DestinationDirectory(const DestinationLimits& limits, Connect connect)
    : limits_(limits), connect_(std::move(connect)), channel_key_{core::random_id(), core::random_id()} {}

DestinationDirectory::Key DestinationDirectory::key_of(const core::UdpAddress& address) {
  return {address.node, {address.node == 0 ? address.ip : core::IpAddress{}, address.port}};
}

/// Returns the first channel number for the socket. The same socket always gets the same number, because its
/// process regards a channel with a greater number as newer.
std::uint32_t DestinationDirectory::first_channel(const Key& key) const {
  std::array<std::uint64_t, 5> words{key.first, 0, 0, key.second.ip.scope, key.second.port};
  std::memcpy(&words[1], key.second.ip.bytes.data(), key.second.ip.bytes.size());
  return static_cast<std::uint32_t>(keyed_hash(channel_key_, words));
}

/// Returns a known destination; null if there is none. An address that does not name its node matches a
/// destination that has that address now.
std::shared_ptr<Destination> DestinationDirectory::known(const core::UdpAddress& address) {
  std::erase_if(known_, [](const auto& entry) { return entry.second.expired(); });
  if (const auto found = known_.find(key_of(address)); found != known_.end()) return found->second.lock();
  if (address.node != 0) return nullptr;
  for (const auto& [key, entry] : known_) {
    std::shared_ptr<Destination> destination = entry.lock();
    if (destination != nullptr && destination->path().address() == SocketAddress{address.ip, address.port})
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
    const core::Lock lock(mutex_);
    host = hosts_.of(to.ip, std::chrono::steady_clock::now());
    destination = known(address);
    flow = destination == nullptr ? unused_flow() : 0;
  }
  if (destination == nullptr) {
    auto fresh =
        std::make_shared<Destination>(to, limits_, flow, connect_, first_channel(key_of(address)), host);
    const core::Lock lock(mutex_);
    destination = known(address);
    if (destination == nullptr) known_[key_of(address)] = destination = std::move(fresh);
  }
  if (address.node != 0) destination->move_to(to, std::move(host));
  if (address.receive_buffer_bytes != 0) destination->set_receive_buffer(address.receive_buffer_bytes);
  return destination;
}

/// Returns a number that no destination has yet. It is random, so that other processes cannot guess it.
std::uint32_t DestinationDirectory::unused_flow() {
  for (;;) {
    const auto flow = static_cast<std::uint32_t>(core::random_id());
    const auto has_it = [flow](const auto& entry) {
      const std::shared_ptr<Destination> destination = entry.second.lock();
      return destination != nullptr && destination->flow() == flow;
    };
    if (std::ranges::none_of(known_, has_it)) return flow;
  }
}

std::shared_ptr<Destination> DestinationDirectory::of_flow(std::uint32_t flow) {
  const core::Lock lock(mutex_);
  for (const auto& [address, known] : known_) {
    if (auto destination = known.lock(); destination != nullptr && destination->flow() == flow)
      return destination;
  }
  return nullptr;
}

namespace {
/// Adds a remark, unless there is an equal one. All processes of a host share the path to it, so one remark
/// about the path is enough for all of them.
void add_remark(LogLevel level, std::string text, std::vector<core::Network::Remark>& remarks) {
  if (text.empty() || std::ranges::find(remarks, text, &core::Network::Remark::text) != remarks.end()) return;
  remarks.push_back({level, std::move(text)});
}

/// Adds remarks about new and ended troubles of the path.
void remark_changes(Destination& to, PathMtu::Time now, std::vector<core::Network::Remark>& remarks) {
  using Change = Destination::Change;
  const Change limit = to.take_limit_change(), silence = to.take_silence_change(now);
  if (limit == Change::found) add_remark(LogLevel::warning, to.path().limit_in_words(), remarks);
  if (limit == Change::over) add_remark(LogLevel::info, to.path().no_limit_in_words(), remarks);
  if (silence == Change::found) add_remark(LogLevel::warning, to.path().silence_in_words(), remarks);
  if (silence == Change::over) add_remark(LogLevel::info, to.path().no_silence_in_words(), remarks);
}
}  // namespace

void DestinationDirectory::look_after(PathMtu::Time now, bool anew,
                                      std::vector<core::Network::Remark>& remarks) {
  {
    const core::Lock lock(mutex_);
    for (const auto& [key, entry] : known_) looked_after_.push_back(entry.lock());
  }
  for (const std::shared_ptr<Destination>& destination : looked_after_) {
    if (destination == nullptr) continue;
    destination->look_after(now, anew);
    remark_changes(*destination, now, remarks);
  }
  looked_after_.clear();
}

}  // namespace sft::udp
