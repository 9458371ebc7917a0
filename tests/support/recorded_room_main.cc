// SPDX-License-Identifier: Apache-2.0
// Writes a recorded room for tests that are not C++: recorded_room FOLDER.

#include "tests/support/recorded_room.h"

int main(int argc, char** argv) {
  if (argc != 2) return 2;
  plumbline::WriteRecordedRoom(argv[1]);
  return 0;
}
