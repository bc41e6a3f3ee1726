#ifndef SOCIAL_FLEET_SOCIAL_GLOBAL_PLANNER_H
#define SOCIAL_FLEET_SOCIAL_GLOBAL_PLANNER_H

#include <atomic>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include <costmap_2d/costmap_2d_ros.h>
#include <nav_core/base_global_planner.h>
#include <nav_msgs/GetPlan.h>
#include <nav_msgs/OccupancyGrid.h>
#include <pluginlib/class_loader.hpp>
#include <ros/callback_queue.h>
#include <ros/ros.h>

#include "plan_client.h"
#include "unknown_obstacles.h"

namespace social_fleet
{
/**
 * move_base's global planner that asks the node social_planner.
 *
 * Subscribes to map (nav_msgs/OccupancyGrid), to tell the costmap's obstacles from the map's walls. Publishes
 * ~NAME/plan (nav_msgs/Path). Serves ~NAME/make_plan (nav_msgs/GetPlan), also while the robot drives. Parameters, all
 * below ~NAME: config/social_global_planner.yaml is their manual.
 */
class SocialGlobalPlanner : public nav_core::BaseGlobalPlanner
{
public:
  SocialGlobalPlanner() = default;
  ~SocialGlobalPlanner() override;

  void initialize(std::string name, costmap_2d::Costmap2DROS* costmap_ros) override;

  bool makePlan(const geometry_msgs::PoseStamped& start, const geometry_msgs::PoseStamped& goal,
                std::vector<geometry_msgs::PoseStamped>& plan) override;

  /** @param cost length and social cost of the path [m]. */
  bool makePlan(const geometry_msgs::PoseStamped& start, const geometry_msgs::PoseStamped& goal,
                std::vector<geometry_msgs::PoseStamped>& plan, double& cost) override;

private:
  struct Parameters
  {
    std::string server, robot, fallback_planner;
    double planner_patience, default_tolerance, start_tolerance, plan_spacing, obstacle_tolerance, overlay_lifetime;
    bool pass_obstacles;
  };

  void readParameters();
  void loadFallback();
  void hearMap(const nav_msgs::OccupancyGridConstPtr& map);
  bool serveMakePlan(nav_msgs::GetPlanRequest& request, nav_msgs::GetPlanResponse& response);

  /** The planner's answer to one request; the obstacles go with it. */
  Answer ask(const geometry_msgs::PoseStamped& start, const geometry_msgs::PoseStamped& goal, double tolerance,
             bool inquiry);

  /**
   * The path of an answer, as local planners want it; false and a word in the log where there is none.
   *
   * @param stamp of all poses: that of the start, for which tf knows where the robot was. Local planners look up the
   *   path at that time, and the present may be too early for tf.
   */
  bool takePath(const Answer& answer, const ros::Time& stamp, std::vector<geometry_msgs::PoseStamped>& plan,
                double& cost);

  /** What the fallback planner says to a question that the planner did not answer. */
  bool fallBack(const std::string& why, const geometry_msgs::PoseStamped& start,
                const geometry_msgs::PoseStamped& goal, std::vector<geometry_msgs::PoseStamped>& plan, double& cost);

  Obstacles unknownObstacles(const geometry_msgs::Point& robot);
  bool isNewGoal(const geometry_msgs::PoseStamped& goal);
  void publish(const std::vector<geometry_msgs::PoseStamped>& plan);

  std::string name_, frame_;
  Parameters parameters_;
  costmap_2d::Costmap2DROS* costmap_ros_ = nullptr;
  std::unique_ptr<PlanClient> client_;
  std::atomic<bool> answered_{ true };  // whether the last request was answered

  std::mutex map_mutex_;
  std::shared_ptr<UnknownObstacles> unknown_;
  std::mutex goal_mutex_;
  geometry_msgs::Pose last_goal_;

  // The loader outlives what it loaded.
  std::unique_ptr<pluginlib::ClassLoader<nav_core::BaseGlobalPlanner>> loader_;
  boost::shared_ptr<nav_core::BaseGlobalPlanner> fallback_;
  std::mutex fallback_mutex_;

  // A queue and a thread of its own: a request that takes its time must not hold up move_base's goals.
  ros::CallbackQueue queue_;
  ros::Publisher plan_publisher_;
  ros::Subscriber map_subscriber_;
  ros::ServiceServer make_plan_;
  std::unique_ptr<ros::AsyncSpinner> spinner_;
};
}  // namespace social_fleet

#endif
