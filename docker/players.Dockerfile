# Our keepers and takers.
#   docker build -f docker/players.Dockerfile -t rcss-hat .
#   docker run --rm --network host rcss-hat play --on localhost:6000 --keepers hand --episodes 100
FROM python:3.11-slim

RUN useradd --create-home --uid 1000 rcss
WORKDIR /home/rcss/rcss-hat
COPY pyproject.toml constraints.txt README.md LICENSE ./
COPY rcss_hat rcss_hat
COPY fake_server fake_server
# The kernels are compiled once, for whoever runs them on whatever processor since about 2015: any user, also where nothing
# can be written.
RUN pip install --no-cache-dir --constraint constraints.txt ".[report,web]" \
 && rcss-hat compile --for-all
USER 1000
WORKDIR /home/rcss

ENTRYPOINT ["rcss-hat"]
CMD ["--help"]
