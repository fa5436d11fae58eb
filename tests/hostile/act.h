// An act is something that hostile programs or mishaps do to honest programs. It begins, goes on for a while,
// and ends. Each act is a function that returns these three parts, and has a line in the table of acts.
#pragma once

#include <sys/types.h>

#include <cstdint>
#include <functional>
#include <random>
#include <span>
#include <string>
#include <string_view>

namespace sft::hostile {

using Random = std::mt19937_64;

/// Parts of an act that are empty do nothing.
struct Act {
  std::function<void()> begin{};
  /// Called every 10 ms while the act lasts.
  std::function<void()> go_on{};
  /// Takes back what would go on by itself. What was broken stays broken.
  std::function<void()> end{};
  /// Returns what the act got although nobody may get it: a sentence, or nothing.
  std::function<std::string()> loot{};
};

/// The facts that an act knows of the programs that it is directed against.
struct Target {
  uid_t account = 0;  ///< that runs the honest programs and their daemon
  Random random{};
};

enum class Attacker : std::uint8_t {
  other_account,  ///< another account of the publisher's host, without any rights
  owner,          ///< the account of the honest programs: what it does to itself by mistake
  neighbour,      ///< root of another host of the network
};

/// The harm that honest programs cannot be spared.
enum class Harm : std::uint8_t {
  none,    ///< nothing: all pairs are served
  floods,  ///< the act takes so much of the network or the processor that samples may fail to come
  /// The act speaks in the names of honest programs, which is not told from true words: samples may fail to
  /// come, unless the honest ones have certificates.
  forges,
  stops_near,  ///< the act stops the subscriber on the publisher's host
  /// Files of another account stay for good, which only that one or root can remove. Until then UDP will do
  /// in place of shared memory, if the status names one of them.
  leaves_files
};

struct Entry {
  std::string_view name;
  std::string_view sentence;  ///< what the attacker does
  Attacker attacker;
  Harm harm;
  Act (*make)(Target& target);
};

/// All acts, in the order of the reader's interest: files, shared memory, mishaps, control, datagrams.
std::span<const Entry> acts();
/// Null if there is no act of that name.
const Entry* find_act(std::string_view name);

}  // namespace sft::hostile
