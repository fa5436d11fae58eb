// Who takes part, and where and how samples are waited for.
#pragma once

#include <compare>
#include <string>
#include <vector>

namespace sft::bench::peers {

enum class Where { one_host, two_hosts };
enum class Waiting { sleeping, spinning };

enum class Way {
  sft_two_fields,
  sft_full,
  sft_loan,  ///< full, from a loan
  iceoryx,   ///< alone, with a copy of each message
  iceoryx_loan,
  cyclone,
  cyclone_iceoryx,
  fast_dds,
  fast_dds_memory,
  tcp,
  udp,
  memcpy_alone  ///< copies the message from one buffer to another one: there is no reader
};

struct Entrant {
  Way way{};
  bool spin_0 = false;  ///< SubscriberOptions::spin is 0, and not the default

  bool is_sft() const { return way <= Way::sft_loan; }
  friend auto operator<=>(const Entrant&, const Entrant&) = default;
};

/// The name for people: "SFT, full, spin 0".
std::string name_of(const Entrant& entrant);
/// The name in figures: "sft_full_spin0".
std::string id_of(const Entrant& entrant);

struct Case {
  Where where{};
  Waiting waiting{};
  std::size_t readers = 1;

  friend auto operator<=>(const Case&, const Case&) = default;
};

/// All who take part in a case, in the order of the tables. Where nobody sleeps there is no spin of 0. With
/// several readers a spin of 0 is tried once, and nothing is copied without a reader.
std::vector<Entrant> entrants(const Case& of);

/// The entrants in the turns of a round. Each round begins with another one, so that nobody always runs right
/// behind the same one, or first.
std::vector<Entrant> turns(std::vector<Entrant> all, std::size_t round);

}  // namespace sft::bench::peers
