#include "udp_transport/flow/remote_path.h"

#include <algorithm>
#include <utility>

#include "udp_transport/io/interfaces.h"

namespace sft::udp {

namespace {
PathMtu mtu_to(const SocketAddress& address, std::size_t kernel_says) {
  return {headers_before_datagram(address.ip),
          std::min(datagram_bytes_of_every_path(address.ip), kernel_says), kernel_says};
}
}  // namespace

RemotePath::RemotePath(const SocketAddress& address, std::size_t kernel_says)
    : address_(address), mtu_(mtu_to(address, kernel_says)), datagram_bytes_(mtu_.datagram_bytes()) {}

void RemotePath::publish_length() noexcept {
  datagram_bytes_.store(mtu_.datagram_bytes(), std::memory_order_relaxed);
  limited_to_.store(mtu_.limited_to(), std::memory_order_relaxed);
  length_is_uncertain_.store(mtu_.is_uncertain(), std::memory_order_relaxed);
}

SocketAddress RemotePath::address() const {
  const core::Lock lock(mutex_);
  return address_;
}

std::string RemotePath::limit_in_words() const {
  const std::size_t limit = limited_to();
  if (limit == 0) return {};
  return "datagrams longer than " + std::to_string(limit) + " bytes do not arrive at '" +
         core::format(address().ip) + "': samples go there in shorter ones";
}

std::string RemotePath::no_limit_in_words() const {
  return "long datagrams no longer get lost on the way to '" + core::format(address().ip) +
         "': samples go there in datagrams of up to " + std::to_string(datagram_bytes()) + " bytes";
}

std::string RemotePath::silence_in_words() const {
  const auto [ip, port] = address();
  return "the host did not answer at " + core::format(ip, port) +
         ": nothing is sent there until it does; see that its firewall lets UDP in, and ours the answers";
}

std::string RemotePath::no_silence_in_words() const {
  const auto [ip, port] = address();
  return "the host answers again at " + core::format(ip, port) + ": samples go there";
}

bool RemotePath::is_at(const core::IpAddress& ip) const {
  const core::Lock lock(mutex_);
  return ip == address_.ip || std::ranges::find(also_at_, ip) != also_at_.end();
}

void RemotePath::learn(const core::IpAddress& ip) {
  const core::Lock lock(mutex_);
  if (also_at_.size() == also_at_max) also_at_.pop_front();
  also_at_.push_back(ip);
}

bool RemotePath::move_to(const SocketAddress& address) noexcept {
  const core::Lock lock(mutex_);
  if (address == std::exchange(address_, address)) return false;
  also_at_.clear();
  return true;
}

void RemotePath::measure_anew(const SocketAddress& address, std::size_t kernel_says) noexcept {
  const PathMtu mtu = mtu_to(address, kernel_says);
  const core::Lock lock(mutex_);
  mtu_ = mtu;
  publish_length();
}

void RemotePath::learn_length(const SocketAddress& asked, std::size_t kernel_says) noexcept {
  const core::Lock lock(mutex_);
  if (asked == address_) mtu_.kernel_says(kernel_says);
  publish_length();
}

void RemotePath::were_lost(std::size_t length, Time now) noexcept {
  const core::Lock lock(mutex_);
  mtu_.lost(length, now);
  publish_length();
}

void RemotePath::arrived(std::size_t length, Time now) noexcept {
  const core::Lock lock(mutex_);
  mtu_.arrived(length, now);
  publish_length();
}

void RemotePath::look_after(Time now) noexcept {
  const core::Lock lock(mutex_);
  mtu_.look_after(now);
  publish_length();
}

}  // namespace sft::udp
