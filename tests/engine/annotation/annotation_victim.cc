// SPDX-License-Identifier: Apache-2.0
// Edits a project at random, with undo, redo and saving, and prints after each step what the
// document has become, until it is killed: annotation_victim PROJECT.json SEED

#include <stdio.h>

#include <cstdlib>

#include <nlohmann/json.hpp>

#include "engine/annotation/annotation_project.h"
#include "engine/base/files.h"
#include "tests/engine/annotation/random_edits.h"

int main(int argc, char** argv) {
  using namespace plumbline;
  if (argc < 3) return 2;
  auto project = AnnotationProject::Open(argv[1]);
  if (!project) {
    fprintf(stderr, "%s\n", project.error().message.c_str());
    return 3;
  }
  Random random({.seed = std::strtoull(argv[2], nullptr, 10)});
  for (;;) {
    const std::uint32_t choice = random.Index(10);
    Status done;
    if (choice == 0) {
      done = (*project)->Save();
    } else if (choice < 3 && (*project)->UndoLabel()) {
      done = (*project)->Undo();
    } else if (choice == 3 && (*project)->RedoLabel()) {
      done = (*project)->Redo();
    } else {
      done = (*project)->Apply(RandomEdit((*project)->document(), random));
    }
    if (!done.ok()) {
      fprintf(stderr, "%s\n", done.error().message.c_str());
      return 4;
    }
    printf("%s\n", HashHex(DocumentToJson((*project)->document()).dump()).c_str());
    fflush(stdout);
  }
}
