// A network's part of report.json. Internal.
#pragma once

#include "batten/io/report/network_report.h"
#include "batten/io/report/report_json.h"

namespace batten {

/// network, regions, joins, choices, shells, flaws, left_over, optimal.
void add_network(Json& json, const NetworkReport& network);

}  // namespace batten
