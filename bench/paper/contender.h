// A program on its own host that writes or reads messages with some middleware. All contenders have the same
// interface.
#pragma once

#include <compare>
#include <cstddef>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "bench/paper/configuration.h"

namespace sft::bench::paper {

class Messages;

class Writer {
 public:
  virtual ~Writer() = default;
  /// True if so many readers get what is written from now on.
  virtual bool serves(std::size_t readers) const = 0;
  /// Writes one of the messages, by its number.
  virtual void write(std::size_t number) = 0;
};

class Reader {
 public:
  virtual ~Reader() = default;
  virtual bool matched() const = 0;
};

/// Called on a thread of the contender when the program has a message, and the fields of it that it needs.
using Arrived = std::function<void()>;

/// The participant of one process. It outlives its writers and readers.
class Peer {
 public:
  virtual ~Peer() = default;
  /// `messages` outlive the writer.
  virtual std::unique_ptr<Writer> writer(const std::string& topic, const Messages& messages) = 0;
  /// Reads these fields of each message. `messages` outlive the reader.
  virtual std::unique_ptr<Reader> reader(const std::string& topic, const Messages& messages, FieldSet fields,
                                         Arrived arrived) = 0;
};

enum class Way {
  sft_recorded,  ///< SFT finds out which fields the program reads
  sft_declared,  ///< the program says so
  sft_full,      ///< the program asks for all fields
  cyclone,
  fast_dds
};

struct Contender {
  Way way{};
  bool reliable = false;
  bool multicast = false;  ///< false: all samples go by unicast; true: the middleware may choose

  bool is_sft() const { return way <= Way::sft_full; }
  friend auto operator<=>(const Contender&, const Contender&) = default;
};

std::string name_of(Way way);
/// The name with the QoS and the network: "Cyclone DDS, reliable, unicast".
std::string name_of(const Contender& contender);

/// SFT with fields that are recorded, declared, and all; Cyclone DDS; Fast DDS. Each of them best effort and
/// reliable, with unicast and with multicast.
std::vector<Contender> all_contenders();

/// The contender whose idle traffic is that of `contender`, since neither fields nor QoS change it.
Contender idle_twin(const Contender& contender);

std::unique_ptr<Peer> open(const Contender& contender);

// These functions open one kind of contender.
std::unique_ptr<Peer> open_sft(const Contender& contender);
std::unique_ptr<Peer> open_cyclone(const Contender& contender);
std::unique_ptr<Peer> open_fast_dds(const Contender& contender);

/// Samples that reliable writers and readers keep.
inline constexpr int depth = 8;

}  // namespace sft::bench::paper
