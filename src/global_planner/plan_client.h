#ifndef SOCIAL_FLEET_PLAN_CLIENT_H
#define SOCIAL_FLEET_PLAN_CLIENT_H

#include <condition_variable>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include <geometry_msgs/Point.h>
#include <ros/ros.h>
#include <social_fleet/PlanPath.h>

namespace social_fleet
{
/** Obstacles of one costmap that the map does not hold. */
struct Obstacles
{
  std::string name;                         ///< under which the planner keeps them
  std::string robot;                        ///< whose plans go round them; empty: everybody's
  std::string frame;                        ///< of the cells
  std::vector<geometry_msgs::Point> cells;  ///< [m]; none: there is nothing in the way
  ros::Duration lifetime;                   ///< after which the planner forgets them by itself
};

/** What the node social_planner said, or why it said nothing. */
struct Answer
{
  bool came = false;
  PlanPathResponse response;
  std::string reason;  ///< why nothing came, or what became of the obstacles; empty: all went well
};

/**
 * Asks the node social_planner, and stops waiting when it takes too long.
 *
 * roscpp's service calls know no time limit: one to a node that hangs never returns. So they are made in a thread of
 * their own, over connections that are cut when the time is over, which ends the call.
 */
class PlanClient
{
public:
  /** @param server the planner's node, whose services are server/plan_path and so on. */
  explicit PlanClient(const std::string& server);
  ~PlanClient();

  /** Hand over the obstacles where they have changed, then ask for a path; returns within `patience`. */
  Answer ask(const PlanPathRequest& request, const Obstacles& obstacles, const ros::WallDuration& patience);

private:
  struct Exchange;
  struct Connection;
  class Worker;

  std::shared_ptr<Worker> worker_;
  std::thread thread_;
  std::timed_mutex one_at_a_time_;
};
}  // namespace social_fleet

#endif
