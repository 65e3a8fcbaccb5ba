#include "batten/io/lines/unique_names.h"

#include <map>
#include <set>

namespace batten {

void make_names_unique(const std::vector<std::string*>& names, const std::string& other) {
  std::map<std::string, int> count, used;
  std::set<std::string> taken;
  for (std::string* name : names) {
    if (name->empty()) *name = other;
    ++count[*name];
  }
  for (const auto& [name, n] : count)
    if (n == 1) taken.insert(name);
  for (std::string* name : names) {
    const std::string shared = *name;
    if (count[shared] == 1) continue;
    do *name = shared + "_" + std::to_string(++used[shared]);
    while (!taken.insert(*name).second);
  }
}

}  // namespace batten
