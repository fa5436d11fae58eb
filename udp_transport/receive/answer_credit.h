// Limits the answers to a writer, since it is not certain that the writer is at the address that its node
// announced. The limit is three times the number of bytes that came in the writer's name, as in QUIC before
// an address is validated (RFC 9000, section 8.1). So an attacker gains little by making this process send
// answers to another host. The class uses no clock, thread or I/O.
#pragma once

#include <algorithm>
#include <cstddef>

namespace sft::udp {

class AnswerCredit {
 public:
  void received(std::size_t bytes) { left_ = std::min(left_ + factor * bytes, left_max); }
  std::size_t left() const { return left_; }
  bool covers(std::size_t bytes) const { return bytes <= left_; }
  void spend(std::size_t bytes) { left_ -= std::min(bytes, left_); }

 private:
  static constexpr std::size_t factor = 3;
  static constexpr std::size_t left_max = std::size_t{1} << 20;

  std::size_t left_ = 0;
};

}  // namespace sft::udp
