// Acts with datagrams that were overheard on the network. They are repeated, altered, and answered in the
// names of other participants.
#pragma once

#include "tests/hostile/act.h"

namespace sft::hostile {

Act heartbeats_a_little_ahead(Target& target);
Act overheard_acks(Target& target);
Act forged_nacks(Target& target);
Act forged_reports(Target& target);
Act heartbeats_that_name_another_host(Target& target);
Act replayed_datagrams(Target& target);
Act replayed_datagrams_of_long_ago(Target& target);
Act mutated_datagrams(Target& target);
Act mutated_samples(Target& target);
Act mutated_answers(Target& target);
Act bit_flips(Target& target);
Act largest_numbers(Target& target);
Act truncated_datagrams(Target& target);

}  // namespace sft::hostile
