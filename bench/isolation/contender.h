// The sensors' program and its readers with some middleware. All contenders have the same interface.
//
// There are two topics, "camera" and "lidar", which carry a message of 6.3 MB in turns. Each reader reads
// both.
#pragma once

#include <array>
#include <compare>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>

namespace sft::bench::isolation {

enum class Middleware { sft, cyclone, fast_dds };
inline constexpr std::array all_middleware{Middleware::sft, Middleware::cyclone, Middleware::fast_dds};

struct Contender {
  Middleware middleware{};
  bool reliable = false;  ///< the delivery to all readers

  friend auto operator<=>(const Contender&, const Contender&) = default;
};

std::string name_of(Middleware middleware);
/// The name with the delivery: "Cyclone DDS, reliable".
std::string name_of(const Contender& contender);

enum class Place {
  local,  ///< on the host of the publisher
  remote
};

inline constexpr std::array topics{"camera", "lidar"};
/// Samples of each topic that reliable writers, and all readers, keep.
inline constexpr int depth = 4;

class Writer {
 public:
  virtual ~Writer() = default;
  /// True if so many readers get what is written from now on.
  virtual bool serves(std::size_t readers) const = 0;
  /// Writes the message with this number. Its topic is `topics[number % topics.size()]`.
  virtual void write(std::uint64_t number) = 0;
};

class Reader {
 public:
  virtual ~Reader() = default;
  /// True if it is matched with the writers of both topics.
  virtual bool is_matched() const = 0;
};

/// Called on a thread of the middleware with the number of a message that the program has in its hands.
using Arrived = std::function<void(std::uint64_t number)>;

std::unique_ptr<Writer> open_writer(const Contender& contender);
std::unique_ptr<Reader> open_reader(const Contender& contender, Place place, Arrived arrived);

// These functions open one kind of contender.
std::unique_ptr<Writer> open_sft_writer(bool reliable);
std::unique_ptr<Reader> open_sft_reader(bool reliable, Place place, Arrived arrived);
std::unique_ptr<Writer> open_cyclone_writer(bool reliable);
std::unique_ptr<Reader> open_cyclone_reader(bool reliable, Arrived arrived);
std::unique_ptr<Writer> open_fast_dds_writer(bool reliable);
std::unique_ptr<Reader> open_fast_dds_reader(bool reliable, Place place, Arrived arrived);

}  // namespace sft::bench::isolation
