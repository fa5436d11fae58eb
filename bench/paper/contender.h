// Who takes part.
#pragma once

#include <compare>
#include <string>
#include <vector>

namespace sft::bench::paper {

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

}  // namespace sft::bench::paper
