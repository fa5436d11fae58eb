// The least that a publisher and its readers do over UDP without IP fragments: a sample goes to one multicast
// group in datagrams that fit into packets, and each reader reads all of them. It has the interface of the
// members in members.h. What gets lost stays lost, and nobody looks at a sample.
#pragma once

#include <netinet/in.h>

#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "bench/many/payload.h"

namespace sft::bench {

class RawMulticastMember {
 public:
  static constexpr const char* name = "raw UDP";

  class Writer {
   public:
    Writer(RawMulticastMember& member, const Payload& payload);
    ~Writer();
    Writer(const Writer&) = delete;
    Writer& operator=(const Writer&) = delete;
    bool serves(std::size_t) const { return true; }
    void write();

   private:
    const int socket_;
    const std::vector<std::uint8_t> sample_;
  };

  /// Its thread reads until the process ends.
  class MaskedReader {
   public:
    MaskedReader(RawMulticastMember& member, const Payload& payload, const std::function<void()>& arrived);
    void ask_for(const std::string&) {}
    bool matched() const { return true; }
  };

  void know_publisher() {}
};

}  // namespace sft::bench
