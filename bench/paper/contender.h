// The contenders of the experiments.
#pragma once

#include <compare>
#include <string>
#include <vector>

namespace sft::bench::paper {

enum class Way {
  sft_recorded,  ///< SFT records which fields the program reads
  sft_declared,  ///< the program declares the fields that it reads
  sft_full,      ///< the program requests all fields
  cyclone,
  fast_dds
};

struct Contender {
  Way way{};
  bool reliable = false;
  bool multicast = false;  ///< false: samples are sent by unicast only; true: multicast is allowed

  bool is_sft() const { return way <= Way::sft_full; }
  friend auto operator<=>(const Contender&, const Contender&) = default;
};

std::string name_of(Way way);
/// Returns the name with the QoS and the network: "Cyclone DDS, reliable, unicast".
std::string name_of(const Contender& contender);

/// Returns SFT with recorded, declared and all fields, Cyclone DDS, and Fast DDS. Each of them is included
/// with best effort and reliable, with unicast and with multicast.
std::vector<Contender> all_contenders();

/// Returns the contender with the same idle traffic as `contender`. Neither fields nor QoS influence idle
/// traffic.
Contender idle_twin(const Contender& contender);

}  // namespace sft::bench::paper
