// Files of --points.
#pragma once
#include <string>
#include <vector>

#include "irradia/Points.h"

namespace irradia::app {

/// Reads lines x,y,z,nx,ny,nz: six numbers, separated by commas, blanks or tabs; empty lines and those that begin with
/// # are left out, and so is a first line of names. Throws Error "file:line: what was found, what was expected".
std::vector<IrradiancePoint> read_points(const std::string& path);

/// Writes a line of names and one a point, in the order of the points, aside, then renames it. Throws Error.
void write_points(const std::string& path, const std::vector<IrradiancePoint>& points,
                  const std::vector<PointIrradiance>& answers);

}  // namespace irradia::app
