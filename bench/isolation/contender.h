// The contenders: the middleware of the sensors' program and of its readers.
#pragma once

#include <array>
#include <compare>
#include <string>

namespace sft::bench::isolation {

enum class Middleware { sft, cyclone, fast_dds };
inline constexpr std::array all_middleware{Middleware::sft, Middleware::cyclone, Middleware::fast_dds};

struct Contender {
  Middleware middleware{};
  bool reliable = false;  ///< true: delivery to all readers is reliable

  friend auto operator<=>(const Contender&, const Contender&) = default;
};

/// Returns the name with the kind of delivery, such as "Cyclone DDS, reliable".
inline std::string name_of(const Contender& contender) {
  constexpr std::array names{"SFT", "Cyclone DDS", "Fast DDS"};
  return names[static_cast<std::size_t>(contender.middleware)] +
         std::string(contender.reliable ? ", reliable" : ", best effort");
}

}  // namespace sft::bench::isolation
