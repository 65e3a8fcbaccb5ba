// Writes the part of report.json about a network. Internal.
#pragma once

#include "batten/io/report/network_report.h"
#include "batten/io/report/report_json.h"

namespace batten {

/// Adds the keys network, regions, joins, choices, shells, flaws, left_over and optimal.
void add_network(Json& json, const NetworkReport& network);

}  // namespace batten
