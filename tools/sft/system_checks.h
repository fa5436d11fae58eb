// What the doctor finds in the system, without a node. Each check looks once and takes no time.
#pragma once

#include "tools/sft/finding.h"

namespace sft::tool {

Finding check_kernel();
Finding check_memlock();
Finding check_receive_buffers();
Finding check_open_files();
Finding check_dev_shm();
Finding check_users();
Finding check_clock();

}  // namespace sft::tool
