// Acts with sftd and with doorbells, and accidents caused by the account that runs the honest programs.
#pragma once

#include "tests/hostile/act.h"

namespace sft::hostile {

Act own_daemon(Target& target);
Act own_daemon_open_to_all(Target& target);
Act own_daemon_that_shrinks(Target& target);
Act own_daemon_that_is_killed(Target& target);
Act shrinking_doorbell(Target& target);
Act doorbell_fifo(Target& target);
Act doorbell_of_nobody(Target& target);
Act doorbells_of_the_honest(Target& target);

Act removed_doorbells(Target& target);
Act removed_shared_memory(Target& target);
Act removed_tmp(Target& target);
Act killed_daemon(Target& target);
Act daemon_killed_often(Target& target);
Act stopped_daemon(Target& target);
Act ended_daemon(Target& target);
Act stopped_near_reader(Target& target);
Act no_descriptors(Target& target);

}  // namespace sft::hostile
