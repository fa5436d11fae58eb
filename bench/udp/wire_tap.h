// Notes when each packet passes a host's interface, and how long it is, without a thread of its own: the
// system writes the notes into memory that is shared with it (packet_mmap of Linux, TPACKET_V2).
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

namespace sft::bench {

struct Packet {
  enum class Kind : std::uint8_t { data, answer };  ///< an answer tells what has come, and what is missing
  std::int64_t at_ns = 0;                           ///< CLOCK_MONOTONIC, as now_ns()
  std::uint32_t bytes = 0;                          ///< with headers; of a train of datagrams, all together
  bool outgoing = false;
  Kind kind = Kind::data;
};

class WireTap {
 public:
  /// `enter` moves the thread that calls it to the host. Another thread calls it, so that the caller's stays
  /// where it is. Ends the program with a message if there can be no tap.
  explicit WireTap(const std::function<void()>& enter);
  ~WireTap();
  WireTap(const WireTap&) = delete;
  WireTap& operator=(const WireTap&) = delete;

  /// Returns the packets of UDP and TCP that have passed since the last call, in their order. Packets that
  /// did not fit into the memory are missing; `lost()` then is true.
  std::vector<Packet> packets();
  bool lost() const { return lost_; }

 private:
  int socket_ = -1;
  std::uint8_t* ring_ = nullptr;
  std::size_t next_ = 0;  ///< the frame that the system fills next
  bool lost_ = false;
};

}  // namespace sft::bench
