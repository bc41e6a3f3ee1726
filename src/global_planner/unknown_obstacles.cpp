#include "unknown_obstacles.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include <costmap_2d/cost_values.h>

namespace social_fleet
{
namespace
{
constexpr int OCCUPIED = 65;  // [%] from which on the planner, too, counts a cell as blocked

/** Whether each of `count` values, `step` apart, or one of its `reach` neighbours is set. */
void dilate(std::vector<bool>& cells, size_t begin, size_t step, int count, int reach)
{
  std::vector<bool> widened(count, false);
  int set_until = -1;
  for (int i = 0, ahead = 0; i < count; ++i)
  {
    for (; ahead < count && ahead <= i + reach; ++ahead)
      if (cells[begin + ahead * step])
        set_until = ahead + reach;
    widened[i] = i <= set_until;
  }
  for (int i = 0; i < count; ++i)
    cells[begin + i * step] = widened[i];
}
}  // namespace

UnknownObstacles::UnknownObstacles(const nav_msgs::OccupancyGrid& map, double tolerance)
  : width_(map.info.width)
  , height_(map.info.height)
  , resolution_(map.info.resolution)
  , x_(map.info.origin.position.x)
  , y_(map.info.origin.position.y)
  , explained_(map.data.size())
{
  const geometry_msgs::Quaternion& turn = map.info.origin.orientation;
  const double yaw = 2.0 * std::atan2(turn.z, turn.w);
  cos_ = std::cos(yaw);
  sin_ = std::sin(yaw);
  for (size_t i = 0; i < map.data.size(); ++i)
    explained_[i] = map.data[i] < 0 || map.data[i] >= OCCUPIED;
  const int reach = std::ceil(tolerance / resolution_);
  for (int row = 0; row < height_; ++row)
    dilate(explained_, static_cast<size_t>(row) * width_, 1, width_, reach);
  for (int column = 0; column < width_; ++column)
    dilate(explained_, column, width_, height_, reach);
}

std::vector<geometry_msgs::Point> UnknownObstacles::find(const costmap_2d::Costmap2D& costmap,
                                                         const geometry_msgs::Point& robot, double clearance) const
{
  std::vector<geometry_msgs::Point> found;
  const unsigned char* costs = costmap.getCharMap();
  const unsigned int width = costmap.getSizeInCellsX(), height = costmap.getSizeInCellsY();
  // A costmap may be coarser than the map: then several of the map's cells lie in one of its.
  const int parts = std::max(1, static_cast<int>(std::ceil(costmap.getResolution() / resolution_ - 1e-6)));
  const double part = costmap.getResolution() / parts;
  for (unsigned int row = 0; row < height; ++row)
  {
    const unsigned char *begin = costs + static_cast<size_t>(row) * width, *end = begin + width, *cell = begin;
    // A costmap has a million cells, of which a few are lethal.
    while ((cell = static_cast<const unsigned char*>(std::memchr(cell, costmap_2d::LETHAL_OBSTACLE, end - cell))))
    {
      const int column = cell++ - begin;
      for (int i = 0; i < parts * parts; ++i)
      {
        geometry_msgs::Point point;
        point.x = costmap.getOriginX() + column * costmap.getResolution() + (i % parts + 0.5) * part;
        point.y = costmap.getOriginY() + row * costmap.getResolution() + (i / parts + 0.5) * part;
        if (!isExplained(point.x, point.y) && std::hypot(point.x - robot.x, point.y - robot.y) >= clearance)
          found.push_back(point);
      }
    }
  }
  return found;
}

bool UnknownObstacles::isExplained(double x, double y) const
{
  const double along = cos_ * (x - x_) + sin_ * (y - y_), across = cos_ * (y - y_) - sin_ * (x - x_);
  const int column = std::floor(along / resolution_), row = std::floor(across / resolution_);
  if (column < 0 || row < 0 || column >= width_ || row >= height_)
    return true;
  return explained_[static_cast<size_t>(row) * width_ + column];
}
}  // namespace social_fleet
