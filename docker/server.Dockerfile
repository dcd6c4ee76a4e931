# A prebuilt rcssserver 19 (Fedora's package) with Keepaway as its default game.
#   docker build -f docker/server.Dockerfile -t rcss-hat-server docker
#   docker run --rm --network host rcss-hat-server
FROM fedora:43

# hadolint ignore=DL3041
RUN dnf --assumeyes --setopt=install_weak_deps=False install rcssserver \
 && dnf clean all \
 && useradd --create-home --uid 1000 rcss \
 && mkdir --parents /home/rcss/conf /logs \
 && chown --recursive rcss:rcss /home/rcss /logs

USER 1000
WORKDIR /home/rcss
# The server writes its configuration files on first start and needs a folder for them.
ENV RCSS_CONF_DIR=/home/rcss/conf
VOLUME /logs
EXPOSE 6000/udp 6001/udp 6002/udp

# A server that lives answers a datagram it does not understand with "(error unknown_command)".
HEALTHCHECK --interval=2s --timeout=3s --start-period=2s --retries=15 \
  CMD ["bash", "-c", "exec 3<>/dev/udp/127.0.0.1/6000 && printf '(ping)\\0' >&3 && timeout 2 head -c 6 <&3 | grep -q '(error'"]

# coach_w_referee: a monitor may end the match (rcss-hat keepers --end-match); auto_mode: then the server exits
# (without extra halves, for with them it kicks off by itself, with whoever is there).
ENTRYPOINT ["rcssserver"]
CMD ["server::half_time=-1", "server::use_offside=0", "server::forbid_kick_off_offside=0", \
     "server::stamina_inc_max=3500", "server::synch_mode=1", "server::synch_offset=80", \
     "server::coach_w_referee=1", "server::auto_mode=1", "server::nr_extra_halfs=0", \
     "server::game_over_wait=1", \
     "server::keepaway=1", "server::keepaway_length=20", "server::keepaway_width=20", \
     "server::visible_angle=360", "server::game_logging=0", "server::text_logging=0", \
     "server::keepaway_logging=1", "server::keepaway_log_dir=/logs", "server::keepaway_log_fixed=1", \
     "server::keepaway_log_fixed_name=keepaway"]
