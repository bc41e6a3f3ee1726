#ifndef SOCIAL_FLEET_UNKNOWN_OBSTACLES_H
#define SOCIAL_FLEET_UNKNOWN_OBSTACLES_H

#include <vector>

#include <costmap_2d/costmap_2d.h>
#include <geometry_msgs/Point.h>
#include <nav_msgs/OccupancyGrid.h>

namespace social_fleet
{
/** Tells which lethal cells of a costmap the map does not explain. */
class UnknownObstacles
{
public:
  /**
   * @param map the static map
   * @param tolerance lethal cells so near to what the map blocks are its walls, seen with errors [m]
   */
  UnknownObstacles(const nav_msgs::OccupancyGrid& map, double tolerance);

  /**
   * Points of the map's cells that the costmap's unexplained lethal cells cover.
   *
   * @param robot what lies nearer to the robot than `clearance` is left out: nobody can plan from within an obstacle,
   *   and how near the robot may pass there is the local planner's business
   * @param clearance [m]
   */
  std::vector<geometry_msgs::Point> find(const costmap_2d::Costmap2D& costmap, const geometry_msgs::Point& robot,
                                         double clearance) const;

private:
  bool isExplained(double x, double y) const;

  int width_, height_;
  double resolution_, x_, y_, cos_, sin_;
  std::vector<bool> explained_;
};
}  // namespace social_fleet

#endif
