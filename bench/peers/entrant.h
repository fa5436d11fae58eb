// The entrants of this benchmark, and the places and ways in which their readers wait for samples.
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
  sft_loan,  ///< SFT with all fields, published from a loan
  iceoryx,   ///< iceoryx alone, with a copy of each message
  iceoryx_loan,
  cyclone,
  cyclone_iceoryx,
  fast_dds,
  fast_dds_memory,
  tcp,
  udp,
  memcpy_alone  ///< a copy of the message from one buffer to another one, without a reader
};

struct Entrant {
  Way way{};
  bool spin_0 = false;  ///< true: SubscriberOptions::spin is 0 instead of the default

  bool is_sft() const { return way <= Way::sft_loan; }
  friend auto operator<=>(const Entrant&, const Entrant&) = default;
};

/// Returns the name for tables, such as "SFT, full, spin 0".
std::string name_of(const Entrant& entrant);
/// Returns the name in figures, such as "sft_full_spin0".
std::string id_of(const Entrant& entrant);

struct Case {
  Where where{};
  Waiting waiting{};
  std::size_t readers = 1;

  friend auto operator<=>(const Case&, const Case&) = default;
};

/// Returns all entrants of a case in the order of the tables. If readers do not sleep, there is no entrant
/// with a spin of 0. With several readers only sft_full also runs with a spin of 0, and memcpy_alone is left
/// out.
std::vector<Entrant> entrants(const Case& of);

/// Returns the entrants in their order in a round. Each round begins with a different entrant, so that no
/// entrant always runs first or just after the same one.
std::vector<Entrant> turns(std::vector<Entrant> all, std::size_t round);

}  // namespace sft::bench::peers
