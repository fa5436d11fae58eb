#include <algorithm>
#include <array>

#include "tests/hostile/act.h"
#include "tests/hostile/control_acts.h"
#include "tests/hostile/daemon_acts.h"
#include "tests/hostile/datagram_acts.h"
#include "tests/hostile/file_acts.h"
#include "tests/hostile/forging_acts.h"
#include "tests/hostile/overheard_acts.h"

namespace sft::hostile {

namespace {

using enum Attacker;
constexpr Harm none = Harm::none;
constexpr Harm floods = Harm::floods;
constexpr Harm forges = Harm::forges;

constexpr std::array all_acts{
    // Files of another account
    Entry{"fifos", "Makes a FIFO at each name of sftd's that is free.", other_account, none, fifos},
    Entry{"directories", "Makes a directory, which is not empty, at each such name.", other_account, none,
          directories},
    Entry{"dangling_links", "Makes a symbolic link to nothing at each such name.", other_account, none,
          dangling_links},
    Entry{"links_elsewhere", "Makes a symbolic link to a program at each such name.", other_account, none,
          links_to_files_of_the_honest},
    Entry{"closed_files", "Makes a file that only it may read at each such name.", other_account, none,
          closed_files},
    Entry{"open_files", "Makes a file that all may write at each such name.", other_account, none,
          open_files},
    Entry{"hard_links", "Makes a file with two names at each such name.", other_account, none, hard_links},
    Entry{"sockets", "Binds a socket that answers nobody at each such name.", other_account, none, sockets},
    Entry{"snatched_names", "Makes FIFOs the moment that a name becomes free.", other_account, none,
          snatched_names},
    Entry{"read_locks", "Holds a read lock on each file that it can read.", other_account, none, read_locks},
    Entry{"waiting_read_locks", "Waits for such locks, to get them when their holder dies.", other_account,
          none, waiting_read_locks},
    Entry{"full_shared_memory", "Fills /dev/shm.", other_account, none, full_shared_memory},
    Entry{"full_tmp", "Fills /tmp.", other_account, none, full_tmp},
    Entry{"no_file_numbers", "Makes 20,000 files in /dev/shm.", other_account, none, no_file_numbers},

    // Daemons and doorbells of another account
    Entry{"own_daemon", "Runs an sftd of its own.", other_account, none, own_daemon},
    Entry{"own_daemon_open_to_all", "Runs an sftd and lets everybody in.", other_account, none,
          own_daemon_open_to_all},
    Entry{"own_daemon_that_shrinks", "Does that and truncates the memory.", other_account, none,
          own_daemon_that_shrinks},
    Entry{"own_daemon_that_is_killed", "Runs an sftd and kills it, so that its files stay.", other_account,
          Harm::leaves_files, own_daemon_that_is_killed},
    Entry{"shrinking_doorbell", "Announces a reader in shared memory and truncates its doorbells.",
          other_account, none, shrinking_doorbell},
    Entry{"doorbell_fifo", "Announces one whose doorbells are a FIFO.", other_account, none, doorbell_fifo},
    Entry{"doorbell_of_nobody", "Announces one that has no doorbells and is not attached.", other_account,
          none, doorbell_of_nobody},
    Entry{"doorbells_of_the_honest", "Announces one whose doorbells are links to those of others.",
          other_account, none, doorbells_of_the_honest},

    // Accidents
    Entry{"removed_doorbells", "Removes the doorbells from /dev/shm.", owner, none, removed_doorbells},
    Entry{"removed_shared_memory", "Removes all names from /dev/shm.", owner, none, removed_shared_memory},
    Entry{"removed_tmp", "Removes all names from /tmp.", owner, none, removed_tmp},
    Entry{"killed_daemon", "Kills sftd with kill -9.", owner, none, killed_daemon},
    Entry{"daemon_killed_often", "Does that every 150 ms.", owner, none, daemon_killed_often},
    Entry{"stopped_daemon", "Stops sftd with SIGSTOP.", owner, none, stopped_daemon},
    Entry{"ended_daemon", "Ends sftd with SIGTERM.", owner, none, ended_daemon},
    Entry{"stopped_near_reader", "Stops the subscriber in shared memory with SIGSTOP.", owner,
          Harm::stops_near, stopped_near_reader},
    Entry{"no_descriptors", "Leaves the publisher no descriptor more.", owner, none, no_descriptors},

    // The control topics
    Entry{"forged_disposals", "Disposes of all records of others, and withdraws them as their writers.",
          neighbour, forges, forged_disposals},
    Entry{"forged_deaths", "Disposes of the participants of others.", neighbour, forges, forged_deaths},
    Entry{"requests_with_the_last_number", "Requests nothing as others' writers, with sequence 2^63.",
          neighbour, forges, requests_with_the_last_number},
    Entry{"altered_announcements", "Announces others' endpoints at other addresses, as their writers.",
          neighbour, forges, altered_announcements},
    Entry{"outdated_records", "Sends heartbeats of RTPS far ahead in the names of others' writers.",
          neighbour, forges, outdated_records},
    Entry{"impersonated_processes", "Says that it belongs to others' processes, which have nothing.",
          neighbour, forges, impersonated_processes},
    Entry{"copied_endpoints", "Announces others' endpoints as those of a process of its own.", neighbour,
          forges, copied_endpoints},
    Entry{"false_life", "Gives heartbeats in others' names, with the digests of other records.", neighbour,
          forges, false_life},
    Entry{"mutated_control", "Sends mutated messages of DDS and heartbeats, also in others' names.",
          neighbour, forges, mutated_control},
    Entry{"truncated_control", "Sends such messages that are cut off.", neighbour, forges, truncated_control},
    Entry{"replayed_control", "Repeats such messages in any order.", neighbour, forges, replayed_control},
    Entry{"requests_to_nobody", "Requests nothing for others' subscribers, 100 sequences ahead.", neighbour,
          none, requests_to_nobody},
    Entry{"repeated_announcements", "Repeats the records of others.", neighbour, none,
          repeated_announcements},
    Entry{"ten_thousand_readers", "Announces 10,000 subscribers.", neighbour, none, ten_thousand_readers},
    Entry{"a_thousand_masks", "Announces 1,000 subscribers with as many masks.", neighbour, none,
          a_thousand_masks},
    Entry{"too_many_writers", "Announces 1,100 publishers.", neighbour, none, too_many_writers},
    Entry{"two_thousand_definitions", "Announces 2,000 definitions of the type.", neighbour, none,
          two_thousand_definitions},
    Entry{"worst_definitions", "Announces 2,000 definitions of 4,096 leaves.", neighbour, none,
          worst_definitions},
    Entry{"names_with_control_characters",
          "Announces nodes and topics with control characters in their names.", neighbour, none,
          names_with_control_characters},
    Entry{"senseless_announcements", "Announces endpoints with senseless fields.", neighbour, none,
          senseless_announcements},
    Entry{"twin_writers", "Announces publishers with the short ids of others.", neighbour, none,
          twin_writers},
    Entry{"reflection", "Announces a subscriber at an address that never answers.", neighbour, none,
          reflection},
    Entry{"reflection_to_the_own_host", "Does that, as if it were on the publisher's own host.", neighbour,
          none, reflection_to_the_own_host},
    Entry{"false_progress", "Reports that others have sent more than anybody received.", neighbour, none,
          false_progress},
    Entry{"false_accounts", "Reports what was sent and lost between others.", neighbour, none,
          false_accounts},
    Entry{"questions_without_end", "Inquires all the time about all topics.", neighbour, none,
          questions_without_end},
    Entry{"unknown_records", "Writes records of unknown kinds and versions, and of others.", neighbour, none,
          unknown_records},
    Entry{"slots_without_end", "Writes records that are none in 40,000 slots.", neighbour, none,
          slots_without_end},
    Entry{"heartbeats_without_records", "Gives heartbeats of records that it does not have.", neighbour, none,
          heartbeats_without_records},
    Entry{"flood_of_heartbeats", "Sends 30,000 heartbeats a second of participants that do not exist.",
          neighbour, floods, flood_of_heartbeats},

    // Datagrams
    Entry{"sequence_jumps", "Sends a sample of a sequence far ahead.", neighbour, none, sequence_jumps},
    Entry{"sequence_jumps_confirmed", "Sends three such samples in a row.", neighbour, none,
          sequence_jumps_confirmed},
    Entry{"heartbeats_from_the_far_future", "Sends heartbeats of 2^62 to 16 channels.", neighbour, none,
          heartbeats_from_the_far_future},
    Entry{"heartbeats_a_little_ahead", "Sends heartbeats 100,000 ahead, in the true channels.", neighbour,
          floods, heartbeats_a_little_ahead},
    Entry{"samples_of_sixteen_megabytes", "Begins 40 samples of 16 MB.", neighbour, none,
          samples_of_sixteen_megabytes},
    Entry{"begun_samples", "Begins 4,096 samples of a channel.", neighbour, none, begun_samples},
    Entry{"swept_acks", "Acknowledges all ordinals of the first channels, one after the other.", neighbour,
          none, swept_acks},
    Entry{"overheard_acks", "Acknowledges a million ordinals ahead in the true channels.", neighbour, floods,
          overheard_acks},
    Entry{"forged_nacks", "Asks for 43 samples again for each heartbeat.", neighbour, floods, forged_nacks},
    Entry{"forged_reports", "Reports that receivers have no room.", neighbour, floods, forged_reports},
    Entry{"marks_of_made_up_senders", "Sends marks of 300 hosts that do not exist.", neighbour, none,
          marks_of_made_up_senders},
    Entry{"marks_for_many_ports", "Sends marks that each name another port.", neighbour, none,
          marks_for_many_ports},
    Entry{"heartbeats_that_name_another_host", "Sends heartbeats so that acks go to another host.", neighbour,
          none, heartbeats_that_name_another_host},
    Entry{"group_offers", "Offers multicast groups to subscribers.", neighbour, none, group_offers},
    Entry{"group_reports", "Reports to publishers what came in groups that do not exist.", neighbour, none,
          group_reports},
    Entry{"replayed_datagrams", "Sends each datagram three times more.", neighbour, none, replayed_datagrams},
    Entry{"replayed_datagrams_of_long_ago", "Sends the first 100 datagrams again and again.", neighbour, none,
          replayed_datagrams_of_long_ago},
    Entry{"mutated_datagrams", "Sends 10,000 mutated datagrams a second.", neighbour, floods,
          mutated_datagrams},
    Entry{"mutated_samples", "Does that with samples and what goes with them.", neighbour, floods,
          mutated_samples},
    Entry{"mutated_answers", "Does that with acks and reports.", neighbour, floods, mutated_answers},
    Entry{"bit_flips", "Sends datagrams in which one bit is wrong.", neighbour, floods, bit_flips},
    Entry{"largest_numbers", "Sends datagrams in which one number is notable.", neighbour, floods,
          largest_numbers},
    Entry{"truncated_datagrams", "Sends datagrams that are cut off.", neighbour, floods, truncated_datagrams},
    Entry{"garbage", "Sends garbage to all ports of nodes.", neighbour, floods, garbage},
    Entry{"garbage_for_discovery", "Sends garbage to the ports of DDS.", neighbour, none,
          garbage_for_discovery},
};

}  // namespace

std::span<const Entry> acts() { return all_acts; }

const Entry* find_act(std::string_view name) {
  const auto found = std::ranges::find(all_acts, name, &Entry::name);
  return found == all_acts.end() ? nullptr : &*found;
}

}  // namespace sft::hostile
