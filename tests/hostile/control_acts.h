// Acts on the control topics in which a process makes false statements about itself, or writes too much.
#pragma once

#include "tests/hostile/act.h"

namespace sft::hostile {

Act requests_to_nobody(Target& target);
Act repeated_announcements(Target& target);
Act ten_thousand_readers(Target& target);
Act a_thousand_masks(Target& target);
Act too_many_writers(Target& target);
Act two_thousand_definitions(Target& target);
Act worst_definitions(Target& target);
Act names_with_control_characters(Target& target);
Act senseless_announcements(Target& target);
Act twin_writers(Target& target);
Act reflection(Target& target);
Act reflection_to_the_own_host(Target& target);
Act false_progress(Target& target);
Act false_accounts(Target& target);
Act questions_without_end(Target& target);
Act unknown_records(Target& target);
Act slots_without_end(Target& target);
Act heartbeats_without_records(Target& target);
Act flood_of_heartbeats(Target& target);

}  // namespace sft::hostile
