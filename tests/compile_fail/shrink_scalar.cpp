// expect: shrink[(][)] takes a sequence of numbers or enumerators
#include "tests/compile_fail/cloud.h"

void misuse(sft::Loan<PointCloud2>& loan) { loan.shrink(F::width, 1); }
